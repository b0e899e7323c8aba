#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/can_device_bus.h"
#include "sinew/hardware/odrive_axis.h"
#include "sinew/hardware/simulated_can_bus.h"
#include "sinew/hardware/simulated_can_port.h"
#include "sinew/hardware/simulated_odrive.h"

namespace sinew {

/// ODrive axes that reel springy cables, on a simulated bus and one virtual clock.
class OdriveBench {
 public:
  static constexpr double kPeriod = 0.01;    // s
  static constexpr double kRadius = 0.01;    // m
  static constexpr double kTensionMax = 20;  // N
  static constexpr double kConstant = 0.5;   // N m/A
  static constexpr double kPretension = 2;   // N at angle 0
  static constexpr double kStiffness = 200;  // N/m
  static constexpr int kMissingLimit = 10;

  struct Options {
    int axes = 2;
    OdriveSettings settings;
    SimulatedOdrive::Parameters parameters;
    double watchdog = 0.1;  // s
    double damping = 0;     // N s/m of the cables
  };

  explicit OdriveBench(int axes) : OdriveBench(makeOptions(axes)) {}
  explicit OdriveBench(const Options& options) : options_(options) {
    std::vector<SimulatedCanBus::Member> simulated;
    std::vector<CanDeviceBus::Member> members;
    for (int i = 0; i < options.axes; ++i) {
      auto drive = std::make_unique<SimulatedOdrive>(i + 1, options.parameters);
      drives.push_back(drive.get());
      simulated.push_back({std::move(drive), {i}});
      members.push_back({makeAxis(i), {i}});
    }
    line = std::make_unique<SimulatedCanBus>(std::move(simulated), 1000000);
    port = std::make_shared<SimulatedCanPort>(*line);
    bus = std::make_unique<CanDeviceBus>([this](std::string&) { return port; }, std::move(members), makeTiming());
    next_ = port->now();
    pull();
    std::string why;
    bus->open(why);
  }

  DeviceTiming makeTiming() const { return {kPeriod, options_.watchdog, 0.002, kMissingLimit}; }

  std::unique_ptr<OdriveAxis> makeAxis(int i) const {
    OdriveSettings settings = options_.settings;
    settings.node = i + 1;
    WinchDescription cable;
    cable.spool_radius = kRadius;
    cable.sign = i % 2 == 0 ? 1 : -1;
    cable.torque_constant = kConstant;
    cable.tension_max = kTensionMax;
    return std::make_unique<OdriveAxis>(settings, cable, makeBounds(i), makeTiming());
  }

  static ActuatorBounds makeBounds(int i) { return {"cable_" + std::to_string(i + 1), -0.1, 0.1, 0.1}; }

  /// m of cable `i` reeled in since the start.
  double reeled(int i) const { return sign(i) * kRadius * line->shaftAngle(i); }
  double tension(int i) const { return std::max(0., kPretension + kStiffness * reeled(i)); }

  /// The mechanics, and the clock, for one period.
  void pass() {
    for (int n = 0; n < 10; ++n) {
      pull();
      line->step(kPeriod / 10);
    }
    next_ = std::max(next_ + duration(kPeriod), port->now());
    port->advanceTo(next_);
  }

  SetUpProgress setUp(bool home_all = false) {
    bus->startSetUp(home_all);
    SetUpProgress progress = SetUpProgress::kBusy;
    for (int n = 0; n < 1000 && progress == SetUpProgress::kBusy; ++n) {
      progress = bus->updateSetUp(port->now());
      pass();
    }
    return progress;
  }

  /// One cycle with these set points [m].
  bool cycle(const std::vector<double>& set_points) {
    const bool ok = bus->writeSetPoints(set_points.data(), port->now()) && bus->read(port->now());
    pass();
    return ok;
  }
  bool run(const std::vector<double>& set_points, int cycles) {
    bool ok = true;
    for (int n = 0; n < cycles; ++n) ok = cycle(set_points) && ok;
    return ok;
  }
  /// Set up, with the zeros where the cables are.
  bool start() {
    if (setUp() != SetUpProgress::kDone) return false;
    for (int i = 0; i < bus->size(); ++i) bus->setZero(i, 0);
    return true;
  }
  /// Cycles until actuator `i` shows `fault`; -1 when it does not within 100.
  int cyclesUntil(int i, std::uint32_t fault, const std::vector<double>& set_points) {
    for (int n = 1; n <= 100; ++n) {
      cycle(set_points);
      if ((reading(i).fault & fault) != 0) return n;
    }
    return -1;
  }
  const ActuatorReading& reading(int i) const { return bus->readings()[static_cast<std::size_t>(i)]; }
  SimulatedOdrive& drive(int i) const { return *drives[static_cast<std::size_t>(i)]; }

  std::vector<SimulatedOdrive*> drives;  // of the simulated bus
  std::unique_ptr<SimulatedCanBus> line;
  std::shared_ptr<SimulatedCanPort> port;
  std::unique_ptr<CanDeviceBus> bus;

 private:
  static Options makeOptions(int axes) {
    Options options;
    options.axes = axes;
    return options;
  }
  static double sign(int i) { return i % 2 == 0 ? 1 : -1; }
  void pull() {
    for (int i = 0; i < line->size(); ++i) line->setLoadTorque(i, -sign(i) * kRadius * tension(i));
  }
  Options options_;
  Time next_{};
};

}  // namespace sinew
