#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/device_factory.h"
#include "sinew/hardware/hardware_driver.h"
#include "sinew/hardware/simulated_line.h"

namespace sinew {

/// A hardware description of `servos` winches as YAML, with `bus`, `servo` and `homing` keys open to change.
inline std::string makeHardwareYaml(int servos, const std::string& homing = "{method: present}",
                                    const std::string& on_timeout = "relax") {
  std::string text =
      "hardware:\n"
      "  bus: {protocol: dynamixel2, port: /dev/none, baud: 1000000, simulated: true, reply_timeout: 0.002,"
      " missing_limit: 10}\n"
      "  rate: 100\n"
      "  command_timeout: 0.1\n"
      "  hold_limit: 0.5\n"
      "  relax_time: 0.4\n"
      "  bus_watchdog: 0.1\n"
      "  servo: {spool_radius: 0.01, sign: 1, displacement_min: -0.03, displacement_max: 0.06, rate_max: 0.04,"
      " tension_max: 20, torque_constant: 1.7826, on_timeout: " +
      on_timeout + ", homing: " + homing + "}\n  actuators:\n";
  for (int i = 1; i <= servos; ++i)
    text += "    - {name: cable_" + std::to_string(i) + ", id: " + std::to_string(i) + "}\n";
  return text;
}

inline std::vector<std::uint8_t> idsOf(const HardwareDescription& description) {
  std::vector<std::uint8_t> ids;
  for (const ActuatorDescription& a : description.actuators) ids.push_back(static_cast<std::uint8_t>(a.id));
  return ids;
}

/// A driver on simulated servos whose cables are springs, on one virtual clock.
class DriverBench {
 public:
  static constexpr double kPeriod = 0.01;   // s
  static constexpr double kPretension = 2;  // N at angle 0

  explicit DriverBench(int servos, const std::string& homing = "{method: present}",
                       const std::string& on_timeout = "relax")
      : description(HardwareDescription::parse(makeHardwareYaml(servos, homing, on_timeout), "bench")),
        bus(idsOf(description), description.buses[0].baud),
        line(std::make_shared<SimulatedLine>(bus)),
        driver(description,
               makeBusGroup(description, {[this](const BusDescription&, std::string& why) { return open(why); }, {}})),
        reader(description.names(), description.quantities()) {
    pull();
  }

  double tension(int i) const {
    return std::max(0., kPretension + stiffness * description.actuators[0].cable.spool_radius * bus.shaftAngle(i));
  }

  /// One period: a bus cycle, then the mechanics.
  const DriverReport& cycle() {
    line->advanceTo(next_);
    const DriverReport& report = driver.update(line->now());
    next_ = std::max(next_ + duration(kPeriod), line->now());
    for (int n = 0; n < 10; ++n) {
      bus.step(kPeriod / 10);
      pull();
    }
    return report;
  }

  const DriverReport& run(double time) {
    for (int n = static_cast<int>(time / kPeriod + 0.5); n > 1; --n) cycle();
    return cycle();
  }

  bool initialise() {
    driver.request(DriverRequest::kInit);
    for (int n = 0; n < 3000 && driver.report().state != DriverState::kReady; ++n) {
      cycle();
      if (driver.report().state == DriverState::kFault) return false;
    }
    for (int i = 0; i < bus.size(); ++i) zero_[static_cast<std::size_t>(i)] = counts(i);
    return driver.report().state == DriverState::kReady;
  }

  CommandVerdict command(const std::vector<double>& value, CommandStatus status = CommandStatus::kOk,
                         std::uint32_t session = 7) {
    const std::vector<std::uint8_t> modes(value.size(), 0);
    return driver.offer(reader.read(session, ++sequence, static_cast<std::uint8_t>(status), description.names(), modes,
                                    value, expected, line->now()));
  }

  std::vector<double> measured() const {
    std::vector<double> out;
    for (const ActuatorReading& r : driver.report().actuators) out.push_back(r.measured);
    return out;
  }

  /// True position of servo `i`, as its encoder counts.
  long counts(int i) const { return std::lround(bus.shaftAngle(i) / kRadiansPerCount); }

  /// True displacement of cable `i` [m] from where it was when `initialise()` returned, as fine as the encoder.
  double displacement(int i) const {
    const auto turned = static_cast<double>(counts(i) - zero_[static_cast<std::size_t>(i)]);
    return description.actuators[0].cable.spool_radius * kRadiansPerCount * turned;
  }

  HardwareDescription description;
  SimulatedServoBus bus;
  std::shared_ptr<SimulatedLine> line;
  bool port_exists = true;
  HardwareDriver driver;
  CommandReader reader;
  std::uint32_t sequence = 0;
  double stiffness = 200;        // N/m of each cable
  std::vector<double> expected;  // N that the next commands say the cables carry

 private:
  std::shared_ptr<ByteStream> open(std::string& why) {
    why = "no such port";
    return port_exists ? line : nullptr;
  }
  void pull() {
    for (int i = 0; i < bus.size(); ++i)
      bus.setLoadTorque(i, -description.actuators[0].cable.spool_radius * tension(i));
  }
  Time next_{std::chrono::seconds(2)};
  std::vector<long> zero_ = std::vector<long>(description.actuators.size(), 0);
};

}  // namespace sinew
