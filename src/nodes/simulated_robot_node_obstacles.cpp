#include "simulated_robot_node_obstacles.h"

#include <utility>

namespace sinew {
namespace {

constexpr double kTransformTolerance = 0.1;  // s

}  // namespace

SimulatedObstacles::SimulatedObstacles(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot)
    : frames_(node, robot->description().frame, kTransformTolerance),
      true_(node, "true_obstacles", ObstacleInbox::Settings::makeTrusting(), robot, frames_),
      tracked_(node, "tracked_obstacles", ObstacleInbox::Settings::makeTrusting(), robot, frames_) {
  for (const Obstacle& obstacle : robot->obstacles()) states_.push_back({obstacle.pose, true});
}

const std::vector<ObstacleState>& SimulatedObstacles::update(double time) {
  ObstacleInbox& inbox = true_.hasPublisher() ? true_ : tracked_;
  inbox.newest().update();
  inbox.predict(time, states_);
  return states_;
}

}  // namespace sinew
