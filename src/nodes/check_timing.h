#pragma once

#include <memory>
#include <string>
#include <vector>

#include "duration_sample.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

struct CycleTiming {
  struct Stage {
    std::string name;
    DurationSample durations;
  };
  std::vector<Stage> stages;
  DurationSample cycle;
  int held = 0;       ///< cycles that were not solved
  bool rests = true;  ///< whether there is an equilibrium with slack cables

  /// Hz at which 99 % of the cycles leave a quarter of their period free.
  double predictRate() const;
};

/// Times the controller while its first effector is led round a small circle about its place of rest.
CycleTiming timeCycles(std::shared_ptr<const RobotModel> robot, int cycles);

}  // namespace sinew
