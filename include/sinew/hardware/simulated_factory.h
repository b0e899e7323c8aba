#pragma once

#include <memory>

#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/simulated_bus.h"

namespace sinew {

/// Devices that stand in for those on bus number `bus` of `hardware`, with the properties that a real one of their kind
/// would have.
std::unique_ptr<SimulatedBus> makeSimulatedBus(const HardwareDescription& hardware, int bus);

}  // namespace sinew
