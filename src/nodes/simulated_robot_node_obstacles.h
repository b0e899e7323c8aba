#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <vector>

#include "frame_finder.h"
#include "obstacle_inbox.h"

namespace sinew {

/// Where the obstacles of the simulated robot are: by `true_obstacles` where somebody publishes these, otherwise by
/// `tracked_obstacles`, taken for the truth.
class SimulatedObstacles {
 public:
  SimulatedObstacles(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot);

  /// At `time` [s, steady], one per obstacle of the robot. One thread only.
  const std::vector<ObstacleState>& update(double time);

 private:
  FrameFinder frames_;
  ObstacleInbox true_, tracked_;
  std::vector<ObstacleState> states_;
};

}  // namespace sinew
