#pragma once

#include <vector>

#include "sinew/hardware/actuator_reading.h"
#include "sinew/hardware/hardware_description.h"

namespace sinew {

/// Finds displacement 0 of every cable: where it is, or where reeling it in slowly makes it taut.
class CableHoming {
 public:
  explicit CableHoming(const std::vector<ActuatorDescription>& actuators);

  /// Begins from the positions read last. Cables with `keep[i]` stay as they are.
  void start(const std::vector<ActuatorReading>& readings, const std::vector<bool>& keep);

  enum class Progress { kBusy, kDone, kFailed };
  /// One cycle of `dt` [s]: moves `setPoints()` on, by what was read. After kFailed `failed()` is the actuator that
  /// found no tension within its travel.
  Progress update(const std::vector<ActuatorReading>& readings, double dt);

  const std::vector<double>& setPoints() const { return set_points_; }  ///< m, before the new zeros
  int failed() const { return failed_; }

 private:
  struct Cable {
    HomingDescription homing;
    double start = 0;  // m
    int taut = 0;      // readings in a row at the tension
    bool done = false;
  };
  static constexpr int kTautReadings = 3;
  std::vector<Cable> cables_;
  std::vector<double> set_points_;
  int failed_ = -1;
};

}  // namespace sinew
