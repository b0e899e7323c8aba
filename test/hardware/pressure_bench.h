#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "hardware/virtual_line.h"
#include "sinew/hardware/serial_pressure_bus.h"
#include "sinew/hardware/simulated_pressure_bus.h"

namespace sinew {

constexpr double kPressurePeriod = 0.01;  // s

inline DeviceTiming makePressureTiming() {
  DeviceTiming timing;
  timing.period = kPressurePeriod;
  timing.watchdog = 0.2;
  timing.reply_timeout = 0.003;
  timing.missing_limit = 10;
  return timing;
}

/// Actuators chamber_1, chamber_2, ..., two on each board.
inline std::vector<PressureActuator> makePressureActuators(int count) {
  std::vector<PressureActuator> actuators(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    PressureActuator& a = actuators[static_cast<std::size_t>(i)];
    a.bounds = {"chamber_" + std::to_string(i + 1), -20000, 80000, 100000};
    a.settings.address = 11 + i / 2;
    a.settings.channel = i % 2 == 0 ? 0 : 2;
    a.settings.pressure_limit = 90000;
  }
  return actuators;
}

inline std::vector<SimulatedPressureBus::Place> placesOf(const std::vector<PressureActuator>& actuators) {
  std::vector<SimulatedPressureBus::Place> places;
  for (const PressureActuator& a : actuators) places.push_back({a.settings.address, a.settings.channel});
  return places;
}

/// A driver's bus, simulated boards and the line between them on a virtual clock.
struct PressureBench {
  explicit PressureBench(int count) : PressureBench(makePressureActuators(count)) {}
  explicit PressureBench(std::vector<PressureActuator> those)
      : actuators(std::move(those)),
        boards(placesOf(actuators)),
        line(std::make_shared<VirtualLine<SimulatedPressureBus>>(boards)),
        bus([this](std::string&) { return line; }, 1000000, makePressureTiming(), actuators),
        set_points(actuators.size(), 0.) {
    std::string why;
    bus.open(why);
  }

  SetUpProgress setUp() {
    bus.startSetUp(true);
    SetUpProgress progress = SetUpProgress::kBusy;
    for (int n = 0; n < 200 && progress == SetUpProgress::kBusy; ++n) {
      progress = bus.updateSetUp(line->now());
      pass();
    }
    for (std::size_t i = 0; i < set_points.size(); ++i) set_points[i] = bus.readings()[i].measured;
    return progress;
  }

  void pass(double time = kPressurePeriod) { line->advanceTo(line->now() + duration(time)); }

  /// A cycle of the driver, on time.
  bool cycle() {
    const Time next = line->now() + duration(kPressurePeriod);
    const bool usable = bus.writeSetPoints(set_points.data(), line->now()) && bus.read(line->now());
    line->advanceTo(next);
    return usable;
  }
  void cycles(int count) {
    for (int n = 0; n < count; ++n) cycle();
  }
  /// Cycles with every set point moving to `target` [Pa] at no more than 80 kPa/s.
  void moveTo(double target, int count) {
    for (int n = 0; n < count; ++n) {
      for (double& s : set_points) s += std::clamp(target - s, -800., 800.);
      cycle();
    }
  }
  std::uint32_t fault(int i) const { return bus.readings()[static_cast<std::size_t>(i)].fault; }

  std::vector<PressureActuator> actuators;
  SimulatedPressureBus boards;
  std::shared_ptr<VirtualLine<SimulatedPressureBus>> line;
  SerialPressureBus bus;
  std::vector<double> set_points;  // Pa gauge
};

}  // namespace sinew
