#include "sinew/hardware/device_factory.h"

#include "sinew/common/config_error.h"
#include "sinew/hardware/servo_chain.h"

namespace sinew {
namespace {

std::unique_ptr<DeviceBus> makeBus(const HardwareDescription& hardware, int index, const LineOpener& opener) {
  const BusDescription& bus = hardware.buses[static_cast<std::size_t>(index)];
  const auto open_serial = [bus, open = opener.serial](std::string& why) { return open(bus, why); };
  switch (bus.type) {
    case BusType::kDynamixel:
      return std::make_unique<ServoChain>(hardware, index, open_serial);
    case BusType::kCan:
    case BusType::kPressureBoard:
      break;
  }
  throw ConfigError("bus " + bus.name, "an unknown protocol", "dynamixel2, can or pressure_board");
}

}  // namespace

std::unique_ptr<BusGroup> makeBusGroup(const HardwareDescription& hardware, const LineOpener& opener) {
  std::vector<BusGroup::Member> members;
  for (int i = 0; i < static_cast<int>(hardware.buses.size()); ++i) {
    const std::vector<int> actuators = hardware.actuatorsOn(i);
    if (actuators.empty())
      throw ConfigError("bus " + hardware.buses[static_cast<std::size_t>(i)].name, "no actuator", "at least one");
    members.push_back({makeBus(hardware, i, opener), hardware.buses[static_cast<std::size_t>(i)].name, actuators});
  }
  return std::make_unique<BusGroup>(std::move(members));
}

}  // namespace sinew
