#include "ros_conversions.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew {
namespace {

/// Obstacles: post, tracked, one cylinder; table, a plane that stays.
const RobotModel& finger() {
  static const RobotModel robot(readRobotDescription(SINEW_SOURCE_DIR "/test/nodes/tracked_finger.yaml"));
  return robot;
}

TrackedObstacles makeMessage() {
  TrackedObstacles message;
  message.name = {"post"};
  message.pose.resize(1);
  message.pose[0].orientation.w = 1;
  message.present = {true};
  return message;
}

/// The reason for which the message is refused, none when it is taken.
std::optional<RefusalReason> check(const TrackedObstacles& message) {
  std::vector<int> obstacles;
  const std::optional<Refusal> refusal = checkObstacles(message, finger(), obstacles);
  if (!refusal) {
    EXPECT_EQ(message.name.size(), obstacles.size());
    return std::nullopt;
  }
  EXPECT_FALSE(refusal->words.empty());
  return refusal->reason;
}

TEST(RosConversions, TakesWhatIsRight) {
  EXPECT_EQ(std::nullopt, check(makeMessage()));
  TrackedObstacles rounded = makeMessage();
  rounded.pose[0].orientation.w = 0.999;
  EXPECT_EQ(std::nullopt, check(rounded));
  TrackedObstacles absent = makeMessage();
  absent.present[0] = false;
  absent.pose[0].orientation.w = 0;
  EXPECT_EQ(std::nullopt, check(absent)) << "the pose of what is absent is not looked at";
}

TEST(RosConversions, RefusesObstaclesByName) {
  TrackedObstacles message = makeMessage();
  message.present.clear();
  EXPECT_EQ(RefusalReason::kWrongSize, check(message));
  message = makeMessage();
  message.pose.resize(2);
  EXPECT_EQ(RefusalReason::kWrongSize, check(message));
  EXPECT_EQ(RefusalReason::kWrongSize, check(TrackedObstacles()));
  message = makeMessage();
  message.name[0] = "lamp";
  EXPECT_EQ(RefusalReason::kUnknownName, check(message));
  message.name[0] = "table";
  EXPECT_EQ(RefusalReason::kNotTracked, check(message));
  message = makeMessage();
  message.name.push_back("post");
  message.pose.push_back(message.pose[0]);
  message.present.push_back(true);
  EXPECT_EQ(RefusalReason::kDuplicateName, check(message));
  message = makeMessage();
  message.pose[0].position.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(RefusalReason::kNotFinite, check(message));
  message = makeMessage();
  message.pose[0].orientation.x = std::numeric_limits<double>::infinity();
  EXPECT_EQ(RefusalReason::kNotFinite, check(message));
  message = makeMessage();
  message.pose[0].orientation.w = 0;
  EXPECT_EQ(RefusalReason::kOrientation, check(message));
}

TEST(RosConversions, APoseComesBack) {
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(0.1, -0.2, 0.3);
  pose.linear() = Eigen::AngleAxisd(2.5, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  EXPECT_LT((toPose(toPoseMessage(pose)).matrix() - pose.matrix()).norm(), 1e-12);
}

TEST(RosConversions, NamesTheObstacleOfAContact) {
  const std::vector<std::string> owners = listPartOwners(finger());
  ASSERT_EQ((std::vector<std::string>{"post", "table"}), owners);
  ContactRow row;
  row.obstacle = 1;
  row.point = Vec3(1, 2, 3);
  row.normal = Vec3::UnitY();
  const Contact contact = makeContactMessage(row, 0.5, -1e-4, owners);
  EXPECT_EQ("table", contact.obstacle);
  EXPECT_EQ(2, contact.point.y);
  EXPECT_EQ(1, contact.normal.y);
  EXPECT_EQ(0.5, contact.force);
  EXPECT_EQ(-1e-4, contact.gap);
  row.obstacle = kSelfContact;
  EXPECT_EQ("self", makeContactMessage(row, 0, 0, owners).obstacle);
}

TEST(RosConversions, TellsWhereTheObstaclesAre) {
  TrackedObstacles message = makeObstaclesMessage(finger());
  EXPECT_EQ("finger_base", message.header.frame_id);
  ASSERT_EQ((std::vector<std::string>{"post", "table"}), message.name);
  std::vector<ObstacleState> states(2);
  states[0].pose.translation() = Vec3(0, 0.5, 0);
  states[1].present = false;
  updateObstaclesMessage(states, message);
  EXPECT_EQ(0.5, message.pose[0].position.y);
  EXPECT_TRUE(message.present[0]);
  EXPECT_FALSE(message.present[1]);
}

}  // namespace
}  // namespace sinew
