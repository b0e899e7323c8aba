#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sinew/inverse/robot_model.h"

namespace sinew {

/// Durations of one stage, one a cycle.
struct StageDurations {
  std::string name;
  std::vector<double> seconds;

  /// The value that `share` in (0, 1] of all lie below or at.
  double calcQuantile(double share) const;
};

struct CycleTiming {
  std::vector<StageDurations> stages;
  StageDurations cycle;
  int held = 0;  ///< cycles that were not solved

  /// Hz at which 99 % of the cycles leave a quarter of their period free.
  double predictRate() const;
};

/// Times the controller while its first effector is led round a small circle about its place of rest.
CycleTiming timeCycles(std::shared_ptr<const RobotModel> robot, int cycles);

}  // namespace sinew
