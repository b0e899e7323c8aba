// A robot that leans on something and is not moved: the pairs that press stay the same.

#include <algorithm>

#include "check_line.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr int kCycles = 1000;
constexpr double kSettled = 1e-4;  // of the load; the volume method's pixels do not let it settle to the last digit
constexpr int kRest = 100;         // cycles in which what is left dies away

using Keys = std::vector<std::uint64_t>;

Keys pressingPairs(const ForwardSimulator& robot) {
  Keys keys;
  for (int i = 0; i < robot.contacts().size(); ++i) {
    if (robot.contactForce()[i] > 0) keys.push_back(robot.contacts().row(i).key);
  }
  return keys;
}

class ContactStability : public testing::TestWithParam<DetectionMethod> {
 protected:
  static std::shared_ptr<const RobotModel> makeWithMethod(const std::string& name) {
    RobotDescription description = readShippedRobot(name);
    description.contacts.method = GetParam();
    return makeRobot(description);
  }

  /// Changes of the pressing pairs while nothing moves, after the robot has been pulled and has settled.
  static void expectSamePairs(const std::string& name, ForwardSimulator& robot, const Actuation& actuation) {
    ASSERT_EQ(robot.settle(actuation, kSettled, 2000), ForwardStatus::kSolved);
    for (int k = 0; k < kRest; ++k) ASSERT_EQ(robot.step(actuation, 0.01), ForwardStatus::kSolved);
    EXPECT_GT(robot.contactForce().maxCoeff(), 0.1) << "N: it does lean on it";
    Keys keys = pressingPairs(robot);
    const VecX effectors = robot.effectors();
    double motion = 0;
    int changes = 0;
    for (int k = 0; k < kCycles; ++k) {
      ASSERT_EQ(robot.step(actuation, 0.01), ForwardStatus::kSolved);
      const Keys now = pressingPairs(robot);
      changes += now != keys;
      keys = now;
      motion = std::max(motion, (robot.effectors() - effectors).cwiseAbs().maxCoeff());
    }
    const std::string method = GetParam() == DetectionMethod::kProximity ? "proximity" : "volume";
    checkFigure("contact_stability." + name + "_" + method + "_changes", changes, "<=", 0, "1");
    checkFigure("contact_stability." + name + "_" + method + "_motion", motion, "<=", 1e-6, "m");
    std::printf("%s, %s: %zu pairs press\n", name.c_str(), method.c_str(), keys.size());
  }
};

TEST_P(ContactStability, TheFingerOnItsPost) {
  ForwardSimulator finger(makeWithMethod("finger"));
  Actuation pull = finger.makeActuation();
  for (int k = 1; k <= 30; ++k) {
    pull.value.setConstant(0.018 * k / 30);
    ASSERT_EQ(finger.step(pull, 0.01), ForwardStatus::kSolved);
  }
  expectSamePairs("finger", finger, pull);
}

TEST_P(ContactStability, TheTrunkUnderItsCylinder) {
  const auto robot = makeWithMethod("trunk_cylinder");
  ForwardSimulator trunk(robot);
  const Actuation still = trunk.makeActuation();
  std::vector<ObstacleState> cylinder = {{robot->obstacles()[0].pose, true}};
  for (int k = 1; k <= 32; ++k) {
    cylinder[0].pose.translation().x() -= 0.001;
    trunk.setObstacles(cylinder);
    ASSERT_EQ(trunk.step(still, 0.01), ForwardStatus::kSolved);
  }
  expectSamePairs("trunk_cylinder", trunk, still);
}

INSTANTIATE_TEST_SUITE_P(Methods, ContactStability,
                         testing::Values(DetectionMethod::kProximity, DetectionMethod::kVolume));

}  // namespace
}  // namespace sinew
