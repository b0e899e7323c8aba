#pragma once

#include <cmath>

namespace sinew {

/// There and back along a line at even speed, with a rest at either end.
struct ObstacleStroke {
  double amplitude = 0.015;  ///< m
  double speed = 0.05;       ///< m/s
  double dwell = 1;          ///< s at either end
  int turns = 0;             ///< 1, there and back; 0: without end

  double calcPeriod() const { return 2 * (amplitude / speed + dwell); }  ///< s

  /// m along the line at `time` [s] since the first start.
  double calcDistance(double time) const {
    if (time <= 0 || (turns > 0 && time >= turns * calcPeriod())) return 0;
    const double way = amplitude / speed;
    const double phase = std::fmod(time, calcPeriod());
    if (phase < way) return speed * phase;
    if (phase < way + dwell) return amplitude;
    if (phase < 2 * way + dwell) return speed * (2 * way + dwell - phase);
    return 0;
  }
};

}  // namespace sinew
