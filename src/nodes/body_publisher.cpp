#include "body_publisher.h"

#include <algorithm>
#include <cerrno>

#include "sinew/constraint/cable.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

BodyPublisher::Snapshot BodyPublisher::makeSnapshot(const RobotModel& robot) {
  Snapshot snapshot;
  snapshot.nodes.resize(robot.surface().nodes.size());
  for (const CableDescription& cable : robot.description().cables) {
    snapshot.cables.emplace_back();
    snapshot.cables.back().reserve(cable.via_points.size() + 1);
  }
  snapshot.effort = VecX::Zero(robot.actuatorCount());
  snapshot.effectors = VecX::Zero(3 * robot.effectorCount());
  snapshot.contacts.resize(static_cast<std::size_t>(robot.maxContacts()));
  snapshot.obstacles.resize(robot.obstacles().size());
  return snapshot;
}

BodyPublisher::BodyPublisher(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot)
    : robot_(std::move(robot)),
      newest_(makeSnapshot(*robot_)),
      message_(makeBodyMessage(*robot_)),
      obstacles_(makeObstaclesMessage(*robot_)),
      part_owners_(listPartOwners(*robot_)),
      publisher_(node.advertise<BodyState>("body_state", 1)),
      contacts_publisher_(node.advertise<ContactArray>("contacts", 1)),
      obstacles_publisher_(node.advertise<TrackedObstacles>("obstacles", 1)) {
  contacts_.header.frame_id = robot_->description().frame;
  for (const EffectorDescription& effector : robot_->description().effectors) {
    geometry_msgs::TransformStamped frame;
    frame.header.frame_id = robot_->description().frame;
    frame.child_frame_id = "effector_" + effector.name;
    frame.transform.rotation.w = 1;
    frames_.push_back(frame);
  }
  if (robot_->hasCarrier()) {
    joints_publisher_ = node.advertise<sensor_msgs::JointState>("joint_states", 1);
    joints_.name = {robot_->description().carrier.name};
    joints_.position.resize(1);
  }
  sem_init(&handed_, 0, 0);
  thread_ = std::thread(&BodyPublisher::run, this);
}

BodyPublisher::~BodyPublisher() {
  stop_ = true;
  sem_post(&handed_);
  thread_.join();
  sem_destroy(&handed_);
}

void BodyPublisher::hand(const InverseController& controller, const CycleInput& input, const CycleOutput& output) {
  Snapshot& snapshot = newest_.back();
  const std::vector<int>& surface = robot_->surface().nodes;
  const std::vector<Vec3>& nodes = controller.nodes();
  for (std::size_t i = 0; i < surface.size(); ++i) snapshot.nodes[i] = nodes[static_cast<std::size_t>(surface[i])];
  for (std::size_t i = 0; i < snapshot.cables.size(); ++i) {
    controller.calcCablePoints(static_cast<int>(i), snapshot.cables[i]);
  }
  snapshot.effort = output.effort;
  snapshot.effectors = output.effectors;
  if (robot_->hasCarrier()) snapshot.travel = output.displacement[robot_->actuatorCount() - 1];
  const ContactList& contacts = controller.contacts();
  snapshot.contact_count = static_cast<std::size_t>(std::min(contacts.size(), output.contacts.count));
  for (std::size_t i = 0; i < snapshot.contact_count; ++i) {
    const auto row = static_cast<int>(i);
    snapshot.contacts[i] = {contacts.row(row), output.contacts.force[row], output.contacts.gap[row]};
  }
  snapshot.obstacles = input.obstacles;
  newest_.publish();
  sem_post(&handed_);
}

void BodyPublisher::run() {
  while (!stop_) {
    if (sem_wait(&handed_) != 0 && errno == EINTR) continue;
    if (!newest_.update()) continue;
    const ros::Time stamp = ros::Time::now();
    publishBody(newest_.front(), stamp);
    publishFrames(newest_.front(), stamp);
    publishContacts(newest_.front(), stamp);
    publishObstacles(newest_.front(), stamp);
    publishCarrier(newest_.front(), stamp);
  }
}

void BodyPublisher::publishBody(const Snapshot& snapshot, const ros::Time& stamp) {
  if (publisher_.getNumSubscribers() == 0) return;
  message_.header.stamp = stamp;
  std::transform(snapshot.nodes.begin(), snapshot.nodes.end(), message_.vertices.begin(), toPoint32);
  message_.cable_points.clear();
  for (std::size_t i = 0; i < snapshot.cables.size(); ++i) {
    message_.cable_size[i] = static_cast<std::uint32_t>(snapshot.cables[i].size());
    message_.cable_tension[i] = snapshot.effort[static_cast<Eigen::Index>(i)];
    for (const Vec3& point : snapshot.cables[i]) message_.cable_points.push_back(toPoint32(point));
  }
  publisher_.publish(message_);
}

// A frame is sent once for a stamp: while the clock is paused there is nothing new to say.
void BodyPublisher::publishFrames(const Snapshot& snapshot, const ros::Time& stamp) {
  if (frames_.empty() || frames_.front().header.stamp == stamp) return;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const Vec3 position = snapshot.effectors.segment<3>(3 * static_cast<Eigen::Index>(i));
    frames_[i].header.stamp = stamp;
    frames_[i].transform.translation.x = position.x();
    frames_[i].transform.translation.y = position.y();
    frames_[i].transform.translation.z = position.z();
  }
  broadcaster_.sendTransform(frames_);
}

void BodyPublisher::publishContacts(const Snapshot& snapshot, const ros::Time& stamp) {
  if (contacts_publisher_.getNumSubscribers() == 0) return;
  contacts_.header.stamp = stamp;
  contacts_.contacts.clear();
  for (std::size_t i = 0; i < snapshot.contact_count; ++i) {
    const PressedContact& contact = snapshot.contacts[i];
    contacts_.contacts.push_back(makeContactMessage(contact.row, contact.force, contact.gap, part_owners_));
  }
  contacts_publisher_.publish(contacts_);
}

void BodyPublisher::publishCarrier(const Snapshot& snapshot, const ros::Time& stamp) {
  if (!joints_publisher_) return;
  joints_.header.stamp = stamp;
  joints_.position.front() = snapshot.travel;
  joints_publisher_.publish(joints_);
}

void BodyPublisher::publishObstacles(const Snapshot& snapshot, const ros::Time& stamp) {
  if (snapshot.obstacles.empty() || obstacles_publisher_.getNumSubscribers() == 0) return;
  obstacles_.header.stamp = stamp;
  updateObstaclesMessage(snapshot.obstacles, obstacles_);
  obstacles_publisher_.publish(obstacles_);
}

}  // namespace sinew
