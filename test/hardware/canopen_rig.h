#pragma once

#include <cstdint>

#include "hardware/canopen_bench.h"
#include "sinew/hardware/canopen_drive.h"
#include "sinew/hardware/simulated_cia402_drive.h"

namespace sinew {

/// One CANopen drive and the simulated one that answers it.
struct CanopenRig {
  static constexpr double kPeriod = 0.01, kWatchdog = 0.1, kRadius = 0.01, kTensionMax = 20;
  static constexpr int kMissingLimit = 5;
  static constexpr std::uint8_t kNode = 5;
  static constexpr double kCountsPerRadian = 4096 * 10 / 6.283185307179586;

  static CanopenSettings makeSettings(std::uint8_t node = kNode) {
    CanopenSettings s;
    s.node = node;
    s.driver_node = 127;
    s.counts_per_turn = 4096;
    s.gear = 10;
    s.rated_unit = 1e-3;
    s.heartbeat = 0.05;
    return s;
  }
  static WinchDescription makeCable(int sign = 1) {
    WinchDescription cable;
    cable.spool_radius = kRadius;
    cable.sign = sign;
    cable.torque_constant = 0.5;
    cable.tension_max = kTensionMax;
    return cable;
  }
  static ActuatorBounds makeBounds() { return {"cable", -0.1, 0.1, 0.2}; }
  static DeviceTiming makeTiming() { return {kPeriod, kWatchdog, 0.004, kMissingLimit}; }

  explicit CanopenRig(const CanopenSettings& settings = makeSettings(), const WinchDescription& cable = makeCable(),
                      const SimulatedCia402Drive::Parameters& parameters = {})
      : node(settings.node, parameters), drive(settings, cable, makeBounds(), makeTiming()) {
    bench.add(node);
    bench.add(drive);
  }

  const ActuatorReading& reading() const { return drive.readings()[0]; }
  SetUpProgress setUp(bool home_all = false) { return bench.setUp(drive, home_all); }
  void cycle(double set_point) { bench.cycle({set_point}); }
  void cycles(int count, double set_point) {
    for (int i = 0; i < count; ++i) cycle(set_point);
  }
  /// Cycles that hold the position measured until one of the bits `fault` shows; -1 when it does not within `limit`.
  int cyclesUntil(std::uint32_t fault, int limit = 100) {
    for (int i = 1; i <= limit; ++i) {
      cycle(reading().measured);
      if ((reading().fault & fault) != 0) return i;
    }
    return -1;
  }

  CanopenBench bench{kPeriod};
  SimulatedCia402Drive node;
  CanopenDrive drive;
};

}  // namespace sinew
