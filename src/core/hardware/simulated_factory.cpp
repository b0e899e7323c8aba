#include "sinew/hardware/simulated_factory.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "sinew/hardware/device_factory.h"
#include "sinew/hardware/simulated_can_bus.h"
#include "sinew/hardware/simulated_cia402_drive.h"
#include "sinew/hardware/simulated_odrive.h"
#include "sinew/hardware/simulated_pressure_bus.h"
#include "sinew/hardware/simulated_pressure_node.h"
#include "sinew/hardware/simulated_servo_bus.h"

namespace sinew {
namespace {

const ActuatorDescription& actuator(const HardwareDescription& hardware, int i) {
  return hardware.actuators[static_cast<std::size_t>(i)];
}

std::unique_ptr<SimulatedBus> makeServos(const HardwareDescription& hardware, int bus) {
  std::vector<std::uint8_t> ids;
  for (const int i : hardware.actuatorsOn(bus)) ids.push_back(static_cast<std::uint8_t>(actuator(hardware, i).id));
  return std::make_unique<SimulatedServoBus>(ids, hardware.buses[static_cast<std::size_t>(bus)].baud);
}

std::unique_ptr<SimulatedCanNode> makeDrive(const ActuatorDescription& a) {
  const auto& settings = std::get<CanopenSettings>(a.settings);
  SimulatedCia402Drive::Parameters p;
  p.counts_per_turn = settings.counts_per_turn;
  p.gear = settings.gear;
  p.absolute_encoder = settings.absolute_encoder;
  if (settings.vendor != 0) p.vendor = settings.vendor;
  if (settings.product != 0) p.product = settings.product;
  return std::make_unique<SimulatedCia402Drive>(static_cast<std::uint8_t>(a.id), p);
}

std::unique_ptr<SimulatedCanNode> makeOdrive(const ActuatorDescription& a, const DeviceTiming& timing) {
  const auto& settings = std::get<OdriveSettings>(a.settings);
  SimulatedOdrive::Parameters p;
  p.firmware05 = settings.firmware == OdriveFirmware::k05;
  p.gear_ratio = settings.gear_ratio;
  p.torque_constant = a.cable.torque_constant;
  p.heartbeat = settings.heartbeat;
  p.cyclic = settings.cyclic ? timing.period / 2 : 0;
  p.watchdog_enabled = !settings.watchdog.given;
  p.watchdog_timeout = timing.watchdog;
  p.enable_endpoint = settings.watchdog.enable;
  p.timeout_endpoint = settings.watchdog.timeout;
  return std::make_unique<SimulatedOdrive>(a.id, p);
}

// A board that reaches the pressures asked of it.
SimulatedPressureBoard::Parameters makeBoardParameters(const HardwareDescription& hardware,
                                                       const std::vector<int>& actuators) {
  SimulatedPressureBoard::Parameters p;
  for (const int i : actuators) {
    const ActuatorDescription& a = actuator(hardware, i);
    const double limit = std::get<PressureBoardSettings>(a.settings).pressure_limit;
    p.channels = std::max(p.channels, a.channel + 1);
    p.range_min = std::min(p.range_min, a.min);
    p.range_max = std::max(p.range_max, 1.2 * limit);
    p.tank_pressure = std::max(p.tank_pressure, 1.5 * limit);
    p.pump_pressure = std::max(p.pump_pressure, 1.6 * limit);
  }
  return p;
}

std::unique_ptr<SimulatedCanNode> makeCanNode(const HardwareDescription& hardware, const CanDeviceGroup& group,
                                              const DeviceTiming& timing) {
  const ActuatorDescription& first = actuator(hardware, group.actuators.front());
  if (first.device == DeviceType::kCanopen) return makeDrive(first);
  if (first.device == DeviceType::kOdrive) return makeOdrive(first, timing);
  std::vector<int> channels;
  for (const int i : group.actuators) channels.push_back(actuator(hardware, i).channel);
  return std::make_unique<SimulatedPressureNode>(first.id, channels, makeBoardParameters(hardware, group.actuators));
}

std::unique_ptr<SimulatedBus> makeCanBus(const HardwareDescription& hardware, int bus) {
  std::vector<SimulatedCanBus::Member> members;
  for (const CanDeviceGroup& group : groupByDevice(hardware, bus))
    members.push_back({makeCanNode(hardware, group, hardware.timing(bus)), group.places});
  return std::make_unique<SimulatedCanBus>(std::move(members), hardware.buses[static_cast<std::size_t>(bus)].bitrate);
}

std::unique_ptr<SimulatedBus> makePressureBus(const HardwareDescription& hardware, int bus) {
  const std::vector<int> actuators = hardware.actuatorsOn(bus);
  std::vector<SimulatedPressureBus::Place> places;
  places.reserve(actuators.size());
  for (const int i : actuators) places.push_back({actuator(hardware, i).id, actuator(hardware, i).channel});
  return std::make_unique<SimulatedPressureBus>(places, hardware.buses[static_cast<std::size_t>(bus)].baud,
                                                makeBoardParameters(hardware, actuators));
}

}  // namespace

std::unique_ptr<SimulatedBus> makeSimulatedBus(const HardwareDescription& hardware, int bus) {
  switch (hardware.buses[static_cast<std::size_t>(bus)].type) {
    case BusType::kDynamixel:
      return makeServos(hardware, bus);
    case BusType::kCan:
      return makeCanBus(hardware, bus);
    case BusType::kPressureBoard:
      break;
  }
  return makePressureBus(hardware, bus);
}

}  // namespace sinew
