#include "sinew/inverse/contact_warnings.h"

#include <gtest/gtest.h>

#include "inverse/contact_robot.h"

namespace sinew {
namespace {

std::string warn(const RobotDescription& description) {
  std::string all;
  const auto robot = makeBarRobot(description);
  for (const std::string& warning : robot->warnings()) all += warning + "\n";
  return all;
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(ContactWarnings, NoneWhereObstaclesStandApart) {
  EXPECT_EQ(warn(makeContactDescription({makeFloor(-0.003), makeSphere(0.01, Vec3(0.15, 0, 0))})), "");
}

TEST(ContactWarnings, SayHowDeepAnObstacleIs) {
  const std::string text = warn(makeContactDescription({makeFloor(0.004)}));
  EXPECT_TRUE(says(text, "bar.yaml: obstacles: floor reaches 4 mm into the body at rest")) << text;
}

TEST(ContactWarnings, NameAnObstacleThatTheBodySurrounds) {
  const std::string text = warn(makeContactDescription({makeSphere(0.002, Vec3(0.055, 0.01, 0.01))}));
  EXPECT_TRUE(says(text, "ball lies inside the body at rest")) << text;
}

TEST(ContactWarnings, NameAnAlarmDistanceOfManyElements) {
  RobotDescription description = makeContactDescription({makeFloor(-0.01)});
  description.contacts.alarm_distance = 0.1;
  const std::string text = warn(description);
  EXPECT_TRUE(says(text, "contacts.alarm_distance: 0.1 m")) << text;
  description.obstacles.clear();
  EXPECT_EQ(warn(description), "");
}

}  // namespace
}  // namespace sinew
