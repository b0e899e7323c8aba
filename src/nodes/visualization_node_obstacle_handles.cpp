#include "visualization_node_obstacle_handles.h"

#include <tf2_geometry_msgs/tf2_geometry_msgs.h>

#include <algorithm>
#include <utility>

#include "ros_conversions.h"
#include "visualization_node_controls.h"

namespace sinew {
namespace {

using visualization_msgs::InteractiveMarker;

constexpr double kSmallestMove = 1e-4;  // m below which a handle does not follow
constexpr double kPlaneHandle = 0.1;    // m

/// m, small enough to leave the view of the obstacle free.
double calcHandleSize(const Obstacle& obstacle) {
  Box box;
  for (const Obstacle::Part& part : obstacle.parts) {
    if (part.shape.kind() != ObstacleShape::Kind::kPlane) box.extend(part.shape.calcBox(part.origin));
  }
  const double largest = (box.upper - box.lower).maxCoeff();
  return largest > 0 ? 0.6 * largest : kPlaneHandle;
}

}  // namespace

ObstacleHandles::ObstacleHandles(const std::string& server_name, ros::Publisher tracked,
                                 const tf2_ros::Buffer& transforms, const std::vector<Obstacle>& obstacles,
                                 double speed)
    : server_(server_name), tracked_(std::move(tracked)), transforms_(transforms), speed_(speed) {
  for (const Obstacle& obstacle : obstacles) {
    if (obstacle.tracked) handles_[obstacle.name].size = calcHandleSize(obstacle);
  }
}

void ObstacleHandles::update(const TrackedObstacles& believed) {
  frame_ = believed.header.frame_id;
  for (std::size_t i = 0; i < std::min(believed.name.size(), believed.pose.size()); ++i) {
    const auto found = handles_.find(believed.name[i]);
    if (found == handles_.end() || found->second.owned) continue;
    Handle& handle = found->second;
    const Pose pose = toPose(believed.pose[i]);
    const bool moved = (pose.matrix() - handle.pose.matrix()).norm() > kSmallestMove;
    if (handle.shown && !moved) continue;
    handle.pose = pose;
    handle.wanted = pose.translation();
    if (!handle.shown) insert(found->first, handle);
    server_.setPose(found->first, believed.pose[i]);
  }
  server_.applyChanges();
}

void ObstacleHandles::insert(const std::string& name, Handle& handle) {
  InteractiveMarker marker;
  marker.header.frame_id = frame_;
  marker.name = name;
  marker.description = name;
  marker.scale = static_cast<float>(handle.size);
  marker.pose = toPoseMessage(handle.pose);
  for (int axis = 0; axis < 3; ++axis) marker.controls.push_back(makeAxisControl(axis));
  server_.insert(marker, [this](const Feedback::ConstPtr& feedback) { onFeedback(feedback); });
  handle.shown = true;
}

void ObstacleHandles::onFeedback(const Feedback::ConstPtr& feedback) {
  const auto found = handles_.find(feedback->marker_name);
  if (found == handles_.end() || feedback->event_type != Feedback::POSE_UPDATE) return;
  geometry_msgs::PointStamped dragged;
  dragged.header.frame_id = feedback->header.frame_id;
  dragged.point = feedback->pose.position;
  try {
    if (dragged.header.frame_id != frame_) dragged = transforms_.transform(dragged, frame_);
  } catch (const tf2::TransformException& error) {
    ROS_WARN_THROTTLE(1.0, "a drag of %s is refused: %s", feedback->marker_name.c_str(), error.what());
    return;
  }
  const Vec3 wanted = toVec3(dragged.point);
  if (!wanted.allFinite()) return;
  found->second.wanted = wanted;
  found->second.owned = true;
}

void ObstacleHandles::moveOn(double period, Handle& handle) const {
  const Vec3 way = handle.wanted - handle.pose.translation();
  const double length = way.norm(), most = speed_ * period;
  handle.pose.translation() += length > most ? Vec3(most / length * way) : way;
}

void ObstacleHandles::report(double period) {
  TrackedObstacles message;
  message.header.frame_id = frame_;
  message.header.stamp = ros::Time::now();
  for (auto& [name, handle] : handles_) {
    if (!handle.owned) continue;
    moveOn(period, handle);
    message.name.push_back(name);
    message.pose.push_back(toPoseMessage(handle.pose));
    message.present.push_back(true);
  }
  if (!message.name.empty()) tracked_.publish(message);
}

void ObstacleHandles::yield(const TrackedObstacles& reported) {
  for (const std::string& name : reported.name) {
    const auto found = handles_.find(name);
    if (found != handles_.end()) found->second.owned = false;
  }
}

}  // namespace sinew
