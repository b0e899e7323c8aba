#include "visualization_node_handles.h"

#include <sinew/EffectorTargets.h>
#include <tf2_geometry_msgs/tf2_geometry_msgs.h>

#include <utility>

#include "ros_conversions.h"
#include "visualization_node_controls.h"

namespace sinew {
namespace {

using visualization_msgs::InteractiveMarker;
using visualization_msgs::InteractiveMarkerControl;
using visualization_msgs::Marker;

constexpr double kHoldTime = 1.0;       // s since the last sign of a hand in which a handle is not moved by others
constexpr double kSmallestMove = 1e-4;  // m below which a handle does not follow

geometry_msgs::Pose makePose(const Vec3& position) {
  geometry_msgs::Pose pose;
  pose.position = toPoint(position);
  pose.orientation.w = 1;
  return pose;
}

/// A ball that moves in the plane of the screen.
InteractiveMarkerControl makeBallControl(double size) {
  Marker ball;
  ball.type = Marker::SPHERE;
  ball.pose.orientation.w = 1;
  ball.scale.x = ball.scale.y = ball.scale.z = 0.35 * size;
  ball.color.r = 0.98f;
  ball.color.g = 0.55f;
  ball.color.b = 0.05f;
  ball.color.a = 0.5f;
  InteractiveMarkerControl control;
  control.name = "move";
  control.orientation.w = 1;
  control.orientation_mode = InteractiveMarkerControl::VIEW_FACING;
  control.interaction_mode = InteractiveMarkerControl::MOVE_3D;
  control.always_visible = true;
  control.independent_marker_orientation = true;
  control.markers.push_back(ball);
  return control;
}

}  // namespace

TargetHandles::TargetHandles(const std::string& server_name, ros::Publisher targets, const tf2_ros::Buffer& transforms)
    : server_(server_name), targets_(std::move(targets)), transforms_(transforms) {}

void TargetHandles::update(const ControllerState& state, const Workspace& workspace, double size) {
  workspace_ = workspace;
  if (state.status == ControllerState::DISABLED || state.header.frame_id != frame_) {
    server_.clear();
    handles_.clear();
    frame_ = state.header.frame_id;
  }
  if (state.status != ControllerState::DISABLED) {
    for (const EffectorState& effector : state.effectors) {
      const auto found = handles_.find(effector.name);
      if (found == handles_.end()) {
        insert(effector, workspace, size);
      } else {
        follow(effector, found->second);
      }
    }
  }
  server_.applyChanges();
}

void TargetHandles::insert(const EffectorState& effector, const Workspace& workspace, double size) {
  const Vec3 position = workspace.calcClamped(toVec3(effector.position));
  InteractiveMarker marker;
  marker.header.frame_id = frame_;
  marker.name = effector.name;
  marker.description = effector.name;
  marker.scale = static_cast<float>(size);
  marker.pose = makePose(position);
  for (int axis = 0; axis < 3; ++axis) marker.controls.push_back(makeAxisControl(axis));
  marker.controls.push_back(makeBallControl(size));
  server_.insert(marker, [this](const Feedback::ConstPtr& feedback) { onFeedback(feedback); });
  handles_[effector.name] = Handle{position, ros::SteadyTime::now()};
}

void TargetHandles::follow(const EffectorState& effector, Handle& handle) {
  if ((ros::SteadyTime::now() - handle.touched).toSec() < kHoldTime) return;
  const Vec3 target = toVec3(effector.target);
  if (!target.allFinite() || (target - handle.position).norm() < kSmallestMove) return;
  handle.position = target;
  server_.setPose(effector.name, makePose(target));
}

void TargetHandles::onFeedback(const Feedback::ConstPtr& feedback) {
  const auto found = handles_.find(feedback->marker_name);
  if (found == handles_.end()) return;
  found->second.touched = ros::SteadyTime::now();
  if (feedback->event_type == Feedback::POSE_UPDATE) drag(*feedback, found->second);
}

void TargetHandles::drag(const Feedback& feedback, Handle& handle) {
  geometry_msgs::PointStamped dragged;
  dragged.header.frame_id = feedback.header.frame_id;
  dragged.point = feedback.pose.position;
  try {
    if (dragged.header.frame_id != frame_) dragged = transforms_.transform(dragged, frame_);
  } catch (const tf2::TransformException& error) {
    ROS_WARN_THROTTLE(1.0, "a drag of %s is refused: %s", feedback.marker_name.c_str(), error.what());
    return;
  }
  const Vec3 wanted = toVec3(dragged.point);
  if (!wanted.allFinite()) return;
  handle.position = workspace_.calcClamped(wanted);

  EffectorTargets targets;
  targets.header.frame_id = frame_;
  targets.header.stamp = ros::Time::now();
  targets.name.push_back(feedback.marker_name);
  targets.pose.push_back(makePose(handle.position));
  targets_.publish(targets);
  if (handle.position != wanted) server_.setPose(feedback.marker_name, targets.pose.front());
  server_.applyChanges();
}

}  // namespace sinew
