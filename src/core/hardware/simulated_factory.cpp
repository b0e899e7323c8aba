#include "sinew/hardware/simulated_factory.h"

#include "sinew/common/config_error.h"
#include "sinew/hardware/simulated_servo_bus.h"

namespace sinew {
namespace {

std::unique_ptr<SimulatedBus> makeServos(const HardwareDescription& hardware, int bus) {
  std::vector<std::uint8_t> ids;
  for (const int i : hardware.actuatorsOn(bus))
    ids.push_back(static_cast<std::uint8_t>(hardware.actuators[static_cast<std::size_t>(i)].id));
  return std::make_unique<SimulatedServoBus>(ids, hardware.buses[static_cast<std::size_t>(bus)].baud);
}

}  // namespace

std::unique_ptr<SimulatedBus> makeSimulatedBus(const HardwareDescription& hardware, int bus) {
  switch (hardware.buses[static_cast<std::size_t>(bus)].type) {
    case BusType::kDynamixel:
      return makeServos(hardware, bus);
    case BusType::kCan:
    case BusType::kPressureBoard:
      break;
  }
  throw ConfigError("bus " + hardware.buses[static_cast<std::size_t>(bus)].name, "nothing to simulate it",
                    "a known bus");
}

}  // namespace sinew
