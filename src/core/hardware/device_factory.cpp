#include "sinew/hardware/device_factory.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "sinew/common/config_error.h"
#include "sinew/hardware/can_device_bus.h"
#include "sinew/hardware/can_identifiers.h"
#include "sinew/hardware/can_pressure_board.h"
#include "sinew/hardware/canopen_drive.h"
#include "sinew/hardware/odrive_axis.h"
#include "sinew/hardware/serial_pressure_bus.h"
#include "sinew/hardware/servo_chain.h"

namespace sinew {
namespace {

const ActuatorDescription& actuator(const HardwareDescription& hardware, int i) {
  return hardware.actuators[static_cast<std::size_t>(i)];
}

PressureActuator makePressureActuator(const ActuatorDescription& a) {
  return {a.bounds(), std::get<PressureBoardSettings>(a.settings)};
}

std::unique_ptr<CanDevice> makeCanDevice(const HardwareDescription& hardware, const CanDeviceGroup& group,
                                         const DeviceTiming& timing) {
  const ActuatorDescription& a = actuator(hardware, group.actuators.front());
  if (a.device == DeviceType::kCanopen)
    return std::make_unique<CanopenDrive>(std::get<CanopenSettings>(a.settings), a.cable, a.bounds(), timing);
  if (a.device == DeviceType::kOdrive)
    return std::make_unique<OdriveAxis>(std::get<OdriveSettings>(a.settings), a.cable, a.bounds(), timing);
  std::vector<PressureActuator> channels;
  for (const int i : group.actuators) channels.push_back(makePressureActuator(actuator(hardware, i)));
  return std::make_unique<CanPressureBoard>(a.id, timing, std::move(channels));
}

// A set point for one must never look like one for another.
void checkIdentifiers(const HardwareDescription& hardware, int bus) {
  std::vector<CanNodeNumber> odrives, drives;
  int driver_node = 0;
  for (const int i : hardware.actuatorsOn(bus)) {
    const ActuatorDescription& a = actuator(hardware, i);
    if (a.device == DeviceType::kOdrive) odrives.push_back({a.name, a.id});
    if (a.device != DeviceType::kCanopen) continue;
    drives.push_back({a.name, a.id});
    driver_node = std::get<CanopenSettings>(a.settings).driver_node;
  }
  if (!drives.empty()) refuseSharedIdentifiers(odrives, drives, driver_node);
}

std::unique_ptr<DeviceBus> makeCanBus(const HardwareDescription& hardware, int bus, CanDeviceBus::OpenPort open) {
  checkIdentifiers(hardware, bus);
  const DeviceTiming timing = hardware.timing(bus);
  std::vector<CanDeviceBus::Member> members;
  for (const CanDeviceGroup& group : groupByDevice(hardware, bus))
    members.push_back({makeCanDevice(hardware, group, timing), group.places});
  return std::make_unique<CanDeviceBus>(std::move(open), std::move(members), timing);
}

std::unique_ptr<DeviceBus> makePressureBus(const HardwareDescription& hardware, int bus,
                                           SerialPressureBus::LineFactory open) {
  std::vector<PressureActuator> actuators;
  for (const int i : hardware.actuatorsOn(bus)) actuators.push_back(makePressureActuator(actuator(hardware, i)));
  const int baud = hardware.buses[static_cast<std::size_t>(bus)].baud;
  return std::make_unique<SerialPressureBus>(std::move(open), baud, hardware.timing(bus), actuators);
}

std::unique_ptr<DeviceBus> makeBus(const HardwareDescription& hardware, int index, const LineOpener& opener) {
  const BusDescription& bus = hardware.buses[static_cast<std::size_t>(index)];
  const auto open_serial = [bus, open = opener.serial](std::string& why) { return open(bus, why); };
  const auto open_can = [bus, open = opener.can](std::string& why) { return open(bus, why); };
  switch (bus.type) {
    case BusType::kDynamixel:
      return std::make_unique<ServoChain>(hardware, index, open_serial);
    case BusType::kCan:
      return makeCanBus(hardware, index, open_can);
    case BusType::kPressureBoard:
      break;
  }
  return makePressureBus(hardware, index, open_serial);
}

}  // namespace

std::vector<CanDeviceGroup> groupByDevice(const HardwareDescription& hardware, int bus) {
  std::vector<CanDeviceGroup> groups;
  int place = 0;
  for (const int i : hardware.actuatorsOn(bus)) {
    const ActuatorDescription& a = actuator(hardware, i);
    auto group = std::find_if(groups.begin(), groups.end(), [&](const CanDeviceGroup& g) {
      const ActuatorDescription& other = actuator(hardware, g.actuators.front());
      return other.device == a.device && other.id == a.id;
    });
    if (group == groups.end()) group = groups.insert(groups.end(), CanDeviceGroup{});
    group->actuators.push_back(i);
    group->places.push_back(place++);
  }
  return groups;
}

std::unique_ptr<BusGroup> makeBusGroup(const HardwareDescription& hardware, const LineOpener& opener) {
  std::vector<BusGroup::Member> members;
  for (int i = 0; i < static_cast<int>(hardware.buses.size()); ++i) {
    const std::vector<int> actuators = hardware.actuatorsOn(i);
    const std::string& name = hardware.buses[static_cast<std::size_t>(i)].name;
    if (actuators.empty()) throw ConfigError("bus " + name, "no actuator", "at least one");
    members.push_back({makeBus(hardware, i, opener), name, actuators});
  }
  return std::make_unique<BusGroup>(std::move(members));
}

}  // namespace sinew
