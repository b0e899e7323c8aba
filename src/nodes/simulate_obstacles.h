#pragma once

#include <vector>

#include "sinew/common/csv_table.h"
#include "sinew/common/sampled_signal.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

/// Where the obstacles of a robot are over time.
class ObstacleSignal {
 public:
  /// They stay where the robot's description has them.
  explicit ObstacleSignal(const RobotModel& robot);

  /// Columns `t`, and of one obstacle or more obstacle_NAME_x .. z [m], if it turns also obstacle_NAME_qx .. qw, and if
  /// it comes and goes obstacle_NAME_present (1 or 0), all in the robot's frame. Throws ConfigError.
  ObstacleSignal(const CsvTable& table, const RobotModel& robot);

  void calcStates(double time, std::vector<ObstacleState>& states) const;

 private:
  SampledSignal values_;  // per obstacle x, y, z, qx, qy, qz, qw, present
};

}  // namespace sinew
