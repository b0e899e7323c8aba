#pragma once

#include <interactive_markers/interactive_marker_server.h>
#include <ros/publisher.h>
#include <sinew/ControllerState.h>
#include <tf2_ros/buffer.h>

#include <map>
#include <string>

#include "visualization_node_workspace.h"

namespace sinew {

/// One interactive marker per effector, by which the user drags its target.
///
/// A handle appears at the effector's actual position when the controller becomes enabled, and goes when it is
/// disabled. While nobody holds it, it follows the controller's target, silently: only a drag publishes.
class TargetHandles {
 public:
  /// `targets` is where the drags go.
  TargetHandles(const std::string& server_name, ros::Publisher targets, const tf2_ros::Buffer& transforms);

  /// `size` [m] is that of a handle.
  void update(const ControllerState& state, const Workspace& workspace, double size);

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedback;
  struct Handle {
    Vec3 position;            ///< m, as shown
    ros::SteadyTime touched;  ///< last sign of the user's hand; rviz gives one every 0.25 s of a drag
  };

  void insert(const EffectorState& effector, const Workspace& workspace, double size);
  void follow(const EffectorState& effector, Handle& handle);
  void onFeedback(const Feedback::ConstPtr& feedback);
  void drag(const Feedback& feedback, Handle& handle);

  interactive_markers::InteractiveMarkerServer server_;
  ros::Publisher targets_;
  const tf2_ros::Buffer& transforms_;
  Workspace workspace_;
  std::string frame_;
  std::map<std::string, Handle> handles_;  ///< by effector name
};

}  // namespace sinew
