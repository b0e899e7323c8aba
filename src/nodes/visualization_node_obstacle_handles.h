#pragma once

#include <interactive_markers/interactive_marker_server.h>
#include <ros/publisher.h>
#include <sinew/TrackedObstacles.h>
#include <tf2_ros/buffer.h>

#include <map>
#include <string>
#include <vector>

#include "sinew/inverse/obstacle.h"

namespace sinew {

/// One interactive marker per tracked obstacle, by which the user pushes it about as if a tracker saw it there.
///
/// A handle stands where the controller believes its obstacle to be, silently, until it is dragged. From then on the
/// obstacle is reported, moving after the hand at a limited speed, until somebody else reports it.
class ObstacleHandles {
 public:
  /// `speed` [m/s] is the fastest that a dragged obstacle moves.
  ObstacleHandles(const std::string& server_name, ros::Publisher tracked, const tf2_ros::Buffer& transforms,
                  const std::vector<Obstacle>& obstacles, double speed);

  /// Shows and moves the handles that nobody holds.
  void update(const TrackedObstacles& believed);
  /// Reports the obstacles that have been dragged, `period` [s] after the last time.
  void report(double period);
  /// What somebody else reports is no longer the user's.
  void yield(const TrackedObstacles& reported);

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedback;
  struct Handle {
    double size = 0;             ///< m
    bool shown = false;          ///< in rviz
    bool owned = false;          ///< dragged, and reported since
    Vec3 wanted = Vec3::Zero();  ///< m, where the hand is
    Pose pose = Pose::Identity();
  };

  void insert(const std::string& name, Handle& handle);
  void onFeedback(const Feedback::ConstPtr& feedback);
  void moveOn(double period, Handle& handle) const;

  interactive_markers::InteractiveMarkerServer server_;
  ros::Publisher tracked_;
  const tf2_ros::Buffer& transforms_;
  double speed_;  // m/s
  std::string frame_;
  std::map<std::string, Handle> handles_;  ///< by obstacle name
};

}  // namespace sinew
