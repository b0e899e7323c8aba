#pragma once

#include <vector>

namespace sinew {

/// The driver's own last word on every set point: finite, in range, and no faster than the rate. It never jumps, also
/// not back into the range: from outside it returns at the rate.
class CommandLimiter {
 public:
  struct Limits {
    double min = 0, max = 0;  ///< m or Pa
    double rate = 0;          ///< m/s or Pa/s
  };

  /// `max_interval` [s]: the longest time a single step is allowed for, so that a stalled caller cannot leap.
  CommandLimiter(std::vector<Limits> limits, double max_interval);

  /// Starts from `applied` [m or Pa], one per actuator: where the devices are now.
  void reset(const std::vector<double>& applied);

  /// Moves every set point towards `wanted` [m or Pa] for `interval` [s]. A value that is not finite keeps its set
  /// point. Returns whether any value was changed by a limit.
  bool update(const std::vector<double>& wanted, double interval);

  const std::vector<double>& applied() const { return applied_; }

 private:
  std::vector<Limits> limits_;
  double max_interval_;
  std::vector<double> applied_;
};

}  // namespace sinew
