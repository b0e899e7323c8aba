#pragma once

#include <sinew/ContactArray.h>
#include <sinew/TrackedObstacles.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "sinew/inverse/obstacle.h"
#include "visualization_node_drawing.h"

namespace sinew {

/// The shapes of a robot's obstacles, drawn where a message says they are.
class ObstacleDrawing {
 public:
  explicit ObstacleDrawing(const std::vector<Obstacle>& obstacles);

  /// One marker a part of every obstacle that is present; planes end after `plane_size` [m].
  void add(const TrackedObstacles& where, const Light& light, double plane_size,
           visualization_msgs::MarkerArray& markers) const;

 private:
  struct Part {
    std::string obstacle;
    ObstacleShape shape;
    Pose origin;  ///< in the obstacle's frame
  };
  std::vector<Part> parts_;
};

/// Every contact as a dot, and the force of those that press as an arrow onto the robot: `force_scale` [m/N] long, but
/// never longer than `max_length` [m].
struct ContactStyle {
  double dot_radius;   ///< m
  double force_scale;  ///< m/N
  double max_length;   ///< m
};
void addContacts(const ContactArray& contacts, const ContactStyle& style, visualization_msgs::MarkerArray& markers);

}  // namespace sinew
