#pragma once

#include "sinew/hardware/device_factory.h"

namespace sinew {

/// Opens the ports that a hardware description names: serial ports, CAN interfaces of the kernel, and serial adapters
/// to a CAN bus (SLCAN).
LineOpener makePortOpener();

}  // namespace sinew
