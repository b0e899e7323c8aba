#include "target_inbox.h"

#include <ros/console.h>

#include <cmath>
#include <sstream>

#include "sinew/robot/robot_description.h"

namespace sinew {

namespace {

TargetSet makeTargetSet(const RobotModel& robot) {
  const auto effectors = static_cast<std::size_t>(robot.effectorCount());
  TargetSet targets;
  targets.positions = VecX::Zero(3 * robot.effectorCount());
  targets.targeted.assign(effectors, false);
  targets.source.resize(effectors);
  targets.topic.assign(effectors, 0);
  return targets;
}

std::string readPoseEffector(const Parameters& parameters, const RobotModel& robot) {
  const std::string first = robot.description().effectors.front().name;
  const std::string name = parameters.textOr("pose_effector", first);
  if (robot.findEffector(name) < 0)
    parameters.fail("pose_effector", name, "an effector of the robot, such as " + first);
  return name;
}

bool isTurned(const geometry_msgs::Quaternion& orientation) {
  return std::abs(orientation.x) + std::abs(orientation.y) + std::abs(orientation.z) > 1e-6;
}

}  // namespace

TargetInbox::TargetInbox(ros::NodeHandle node, const Parameters& parameters, std::shared_ptr<const RobotModel> robot,
                         const FrameFinder& frames)
    : robot_(std::move(robot)),
      frames_(frames),
      pose_effector_(readPoseEffector(parameters, *robot_)),
      timeout_(parameters.numberOr("target_timeout", 0.5, 1e-3, 1e6)),
      max_jump_(parameters.numberOr("max_target_jump", 0.0, 0.0, kFarthest)),
      targets_(makeTargetSet(*robot_)),
      newest_(targets_),
      topics_{node.resolveName("targets"), node.resolveName("target_pose")} {
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  targets_subscriber_ = node.subscribe("targets", 10, &TargetInbox::onTargets, this, hints);
  pose_subscriber_ = node.subscribe("target_pose", 10, &TargetInbox::onTargetPose, this, hints);
}

void TargetInbox::onTargets(const EffectorTargets& message) {
  receive(message, kTargets);
}

void TargetInbox::onTargetPose(const geometry_msgs::PoseStamped& message) {
  EffectorTargets targets;
  targets.header = message.header;
  targets.name.push_back(pose_effector_);
  targets.pose.push_back(message.pose);
  receive(targets, kTargetPose);
}

void TargetInbox::receive(const EffectorTargets& message, Topic topic) {
  const std::optional<Refusal> refusal = read(message, topic);
  if (refusal) {
    refusals_.add(*refusal);
    ROS_WARN_STREAM_THROTTLE(
        5.0, "refused a message on " << topics_[static_cast<std::size_t>(topic)] << ": " << refusal->words);
    return;
  }
  accepted_.fetch_add(1, std::memory_order_relaxed);
  newest_.write(targets_);
}

std::optional<Refusal> TargetInbox::read(const EffectorTargets& message, Topic topic) {
  if (targets_.epoch != epoch()) {
    targets_.epoch = epoch();
    targets_.targeted.assign(targets_.targeted.size(), false);
  }
  if (auto refusal = checkTargets(message, *robot_, effectors_)) return refusal;
  if (auto refusal = checkStamp(message.header, timeout_)) return refusal;
  Pose to_robot;
  if (auto refusal = frames_.find(message.header, to_robot)) return refusal;
  positions_.clear();
  for (std::size_t i = 0; i < effectors_.size(); ++i) {
    positions_.push_back(to_robot * toVec3(message.pose[i].position));
    if (auto refusal = checkPosition(effectors_[i], positions_.back())) return refusal;
  }
  for (std::size_t i = 0; i < effectors_.size(); ++i) {
    const auto effector = static_cast<std::size_t>(effectors_[i]);
    targets_.positions.segment<3>(3 * effectors_[i]) = positions_[i];
    targets_.targeted[effector] = true;
    targets_.source[effector] = {message.header.stamp, message.header.seq};
    targets_.topic[effector] = topic;
  }
  noteOrientation(message);
  return std::nullopt;
}

std::optional<Refusal> TargetInbox::checkPosition(int effector, const Vec3& position) const {
  const std::string name =
      "the target of effector '" + robot_->description().effectors[static_cast<std::size_t>(effector)].name + "'";
  if (!position.allFinite()) return Refusal{RefusalReason::kNotFinite, name + " is not finite in the robot's frame"};
  std::ostringstream words;
  if (position.norm() > kFarthest) {
    words << name << " is " << position.norm() << " m from the robot, more than " << kFarthest << " m";
    return Refusal{RefusalReason::kJump, words.str()};
  }
  if (max_jump_ == 0 || !targets_.targeted[static_cast<std::size_t>(effector)]) return std::nullopt;
  const double jump = (position - targets_.positions.segment<3>(3 * effector)).norm();
  if (jump <= max_jump_) return std::nullopt;
  words << name << " jumps by " << jump << " m, more than max_target_jump, " << max_jump_ << " m";
  return Refusal{RefusalReason::kJump, words.str()};
}

void TargetInbox::noteOrientation(const EffectorTargets& message) {
  if (orientation_noted_) return;
  for (const geometry_msgs::Pose& pose : message.pose) orientation_noted_ |= isTurned(pose.orientation);
  if (orientation_noted_) ROS_INFO("targets carry an orientation: point effectors follow the position only");
}

}  // namespace sinew
