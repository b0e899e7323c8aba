#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
#include <std_msgs/Float64.h>
#include <visualization_msgs/Marker.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "parameters.h"
#include "real_time.h"
#include "sinew/common/config_error.h"
#include "sinew/robot/robot_description.h"
#include "target_trajectory.h"

namespace sinew {

namespace {

const EffectorDescription& findEffector(const RobotDescription& robot, const Parameters& parameters,
                                        const std::string& key, const std::string& otherwise) {
  const std::string name = parameters.textOr(key, otherwise);
  for (const EffectorDescription& effector : robot.effectors) {
    if (effector.name == name) return effector;
  }
  parameters.fail(key, name, "an effector of the robot");
}

constexpr double kShortening = 0.02;  // 1, of the body by its cables, so that they stay taut

/// Centre of a horizontal curve of `radius` [m] on the robot's z axis, where cables that only pull can bring the end of
/// a slender body of rest length L: an arc of constant curvature that ends r from the axis ends L - 2/3 r^2 / L along
/// it, up to r^4.
Vec3 calcCentre(const EffectorDescription& effector, double radius) {
  const double length = effector.point.z();
  if (length == 0) return Vec3::Zero();
  return Vec3(0, 0, (1 - kShortening) * length - 2.0 / 3.0 * radius * radius / length);
}

/// The same for the tip of an S of two arcs: the first, of length a, ends m = a t1 / 2 off the axis with slope t1; the
/// second, of length b, turns back by t2 and ends r on the other side, b t2 / 2 = r + m + b t1. Its height along the
/// axis is shorter than its length by the integral of half the slope squared, b (t1^2 - t1 t2 + t2^2 / 3) / 2.
Vec3 calcSCentre(const EffectorDescription& tip, double radius, const EffectorDescription& middle,
                 double middle_radius) {
  const double a = middle.point.z();
  const double b = tip.point.z() - a;
  if (a == 0 || b == 0) return calcCentre(tip, radius);
  const double t1 = 2 * middle_radius / a;
  const double t2 = 2 * (radius + middle_radius + b * t1) / b;
  const double drop = b * (t1 * t1 - t1 * t2 + t2 * t2 / 3) / 2;
  return calcCentre(middle, middle_radius) + Vec3(0, 0, (1 - kShortening) * b - drop);
}

TargetTrajectory makeTrajectory(const Parameters& parameters, const RobotDescription& robot) {
  const std::string kind = parameters.text("trajectory");
  const std::string csv = ".csv";
  if (kind.size() > csv.size() && kind.compare(kind.size() - csv.size(), csv.size(), csv) == 0) {
    return TargetTrajectory::readCsv(kind);
  }
  const EffectorDescription& tip = findEffector(robot, parameters, "effector", robot.effectors.front().name);
  const double radius = parameters.numberOr("radius", 0.04, 1e-6);
  TrajectoryTiming timing;
  timing.period = parameters.numberOr("period", 8, 1e-3);
  timing.turns = parameters.numberOr("turns", 2, 1e-3);
  if (kind == "s_shape") {
    const EffectorDescription& middle = findEffector(robot, parameters, "middle_effector", "middle");
    const double middle_radius = parameters.numberOr("middle_radius", radius / 8, 0);
    const Vec3 tip_centre = parameters.vec3Or("centre", calcSCentre(tip, radius, middle, middle_radius));
    const Vec3 middle_centre = parameters.vec3Or("middle_centre", calcCentre(middle, middle_radius));
    return TargetTrajectory::makeSShape(tip.name, tip_centre, radius, middle.name, middle_centre, middle_radius,
                                        timing);
  }
  const Vec3 centre = parameters.vec3Or("centre", calcCentre(tip, radius));
  if (kind == "circle") return TargetTrajectory::makeCircle(tip.name, centre, radius, timing);
  if (kind == "square") return TargetTrajectory::makeSquare(tip.name, centre, radius, timing);
  parameters.fail("trajectory", kind, "circle, square, s_shape or the path of a .csv file");
}

}  // namespace

/// Sends targets along a curve as long as the controller is enabled. Whenever it becomes so, the targets start where
/// the effectors are, go over smoothly to where the curve was left, and move on from there.
class TargetTrajectoryNode {
 public:
  TargetTrajectoryNode(ros::NodeHandle node, const Parameters& parameters)
      : TargetTrajectoryNode(node, parameters, readRobotDescription(parameters.text("robot"))) {}

 private:
  TargetTrajectoryNode(ros::NodeHandle node, const Parameters& parameters, const RobotDescription& robot)
      : trajectory_(makeTrajectory(parameters, robot)),
        ramp_duration_(parameters.numberOr("ramp_duration", 3, 0)),
        start_delay_(parameters.numberOr("start_delay", 0, 0)),
        period_(1 / parameters.numberOr("rate", 100, 1, 2000)),
        targets_publisher_(node.advertise<EffectorTargets>("targets", 1)),
        time_publisher_(node.advertise<std_msgs::Float64>("trajectory_time", 1)),
        path_publisher_(node.advertise<visualization_msgs::Marker>("target_path", 4, true)) {
    message_.header.frame_id = robot.frame;
    message_.name = trajectory_.effectors();
    message_.pose.resize(message_.name.size());
    for (geometry_msgs::Pose& pose : message_.pose) pose.orientation.w = 1;
    trajectory_.calcPositions(0, positions_);
    ramp_start_ = positions_;
    publishPath();
    state_subscriber_ =
        node.subscribe("controller_state", 1, &TargetTrajectoryNode::onState, this, ros::TransportHints().tcpNoDelay());
    timer_ = node.createSteadyTimer(ros::WallDuration(period_), &TargetTrajectoryNode::onTimer, this);
  }

  void onState(const ControllerState& state) {
    heard_ = steadyNow();
    const bool enabled = state.status != ControllerState::DISABLED;
    if (enabled && (!enabled_ || state.session != session_)) {
      session_ = state.session;
      startRamp(state);
    }
    enabled_ = enabled;
  }

  void startRamp(const ControllerState& state) {
    for (std::size_t i = 0; i < ramp_start_.size(); ++i) {
      const auto effector =
          std::find_if(state.effectors.begin(), state.effectors.end(),
                       [&](const EffectorState& candidate) { return candidate.name == message_.name[i]; });
      if (effector == state.effectors.end()) {
        throw ConfigError("trajectory", message_.name[i], "an effector of the controller");
      }
      ramp_start_[i] = Vec3(effector->position.x, effector->position.y, effector->position.z);
    }
    trajectory_.calcPositions(curve_time_, ramp_end_);
    trajectory_.calcVelocities(curve_time_ + 1e-3, ramp_velocity_);
    ramp_begin_ = steadyNow() + (curve_time_ == 0 ? start_delay_ : 0.0);
    const double wait = ramp_begin_ - steadyNow() + ramp_duration_;
    ROS_INFO_STREAM("the curve " << (curve_time_ == 0 ? "starts in " : "goes on in ") << wait << " s");
  }

  void onTimer(const ros::SteadyTimerEvent&) {
    constexpr double kSilence = 0.5;  // s without a word of the controller
    const double now = steadyNow();
    if (now - heard_ > kSilence) enabled_ = false;
    if (!enabled_ || now < ramp_begin_) return;
    const double ramp_time = now - ramp_begin_;
    const bool ramping = ramp_time < ramp_duration_;
    if (ramping) {
      for (std::size_t i = 0; i < positions_.size(); ++i) {
        positions_[i] = calcRamp(ramp_start_[i], ramp_end_[i], ramp_velocity_[i], ramp_duration_, ramp_time);
      }
      curve_begin_ = ramp_begin_ + ramp_duration_ - curve_time_;
    } else {
      curve_time_ = now - curve_begin_;
      trajectory_.calcPositions(curve_time_, positions_);
    }
    publishTargets(ramping ? ramp_time - ramp_duration_ : curve_time_);
  }

  void publishTargets(double time) {
    message_.header.stamp = ros::Time::now();
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      message_.pose[i].position.x = positions_[i].x();
      message_.pose[i].position.y = positions_[i].y();
      message_.pose[i].position.z = positions_[i].z();
    }
    targets_publisher_.publish(message_);
    std_msgs::Float64 time_message;
    time_message.data = time;
    time_publisher_.publish(time_message);
  }

  void publishPath() {
    constexpr int kPoints = 400;
    visualization_msgs::Marker marker;
    marker.header.frame_id = message_.header.frame_id;
    marker.type = visualization_msgs::Marker::LINE_STRIP;
    marker.pose.orientation.w = 1;
    marker.scale.x = 1e-3;
    marker.color.g = 0.6F;
    marker.color.b = 0.9F;
    marker.color.a = 0.8F;
    std::vector<Vec3> positions;
    for (std::size_t i = 0; i < message_.name.size(); ++i) {
      marker.ns = message_.name[i];
      marker.points.clear();
      for (int k = 0; k <= kPoints; ++k) {
        trajectory_.calcPositions(trajectory_.duration() * k / kPoints, positions);
        geometry_msgs::Point point;
        point.x = positions[i].x();
        point.y = positions[i].y();
        point.z = positions[i].z();
        marker.points.push_back(point);
      }
      path_publisher_.publish(marker);
    }
  }

  TargetTrajectory trajectory_;
  double ramp_duration_, start_delay_, period_;  // s
  ros::Publisher targets_publisher_, time_publisher_, path_publisher_;
  ros::Subscriber state_subscriber_;
  ros::SteadyTimer timer_;
  EffectorTargets message_;
  std::vector<Vec3> positions_, ramp_start_, ramp_end_, ramp_velocity_;  // m, m/s
  bool enabled_ = false;
  std::uint32_t session_ = 0;
  double heard_ = 0;        // s, steady
  double ramp_begin_ = 0;   // s, steady
  double curve_begin_ = 0;  // s, steady: when the curve's time was 0
  double curve_time_ = 0;   // s along the curve
};

}  // namespace sinew

int main(int argc, char** argv) {
  ros::init(argc, argv, "target_trajectory");
  try {
    sinew::TargetTrajectoryNode node(ros::NodeHandle(), sinew::Parameters(ros::NodeHandle("~")));
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
