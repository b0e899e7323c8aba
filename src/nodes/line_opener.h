#pragma once

#include "sinew/hardware/device_factory.h"

namespace sinew {

/// Opens the ports of real and simulated devices. A real robot must not be moved by a recording or by a simulation
/// that shares its topics: unless `simulated`, or the bus says so itself, a real port stays closed while /use_sim_time
/// is true.
LineOpener makeLineOpener(bool simulated);

}  // namespace sinew
