#pragma once

#include <string>
#include <vector>

#include "sinew/contact/obstacle_shape.h"
#include "sinew/robot/obstacle_description.h"

namespace sinew {

/// A rigid body that the robot may touch, ready for detection.
struct Obstacle {
  struct Part {
    ObstacleShape shape;
    Pose origin;  ///< in the obstacle's frame
  };
  std::string name;
  std::vector<Part> parts;
  Pose pose;             ///< in the robot's frame, until something else is heard
  bool tracked = false;  ///< its pose is heard while running
};

/// Where an obstacle is now.
struct ObstacleState {
  Pose pose = Pose::Identity();  ///< in the robot's frame
  bool present = true;
};

/// Throws ConfigError for sizes and meshes that make no body.
Obstacle makeObstacle(const ObstacleDescription& description);

}  // namespace sinew
