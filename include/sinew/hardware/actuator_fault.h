#pragma once

#include <cstdint>

namespace sinew {

/// The most telling of the faults (ActuatorFault) in words that go on after the actuator's name: "is overheated".
const char* describeFault(std::uint32_t fault);

}  // namespace sinew
