// Effectors that are to hold: their error comes before that of the others.

#include <gtest/gtest.h>

#include "inverse/contact_robot.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr int kTip = 0, kMiddle = 1;

/// The bar with its height at the middle asked for too, in conflict with the tip's.
RobotDescription makeDescription(bool hold, const std::vector<ObstacleDescription>& obstacles = {}) {
  RobotDescription robot = makeContactDescription(obstacles);
  robot.effectors[kTip].axes = {{false, true, true}};
  robot.effectors[kTip].hold = hold;
  robot.effectors.push_back(robot.effectors[kTip]);
  robot.effectors[kMiddle].name = "middle";
  robot.effectors[kMiddle].point = Vec3(0.05, 0.01, 0.01);
  robot.effectors[kMiddle].hold = false;
  return robot;
}

class HeldBar {
 public:
  explicit HeldBar(const RobotDescription& description)
      : robot_(makeBarRobot(description)),
        controller_(robot_),
        input(controller_.makeInput()),
        output(controller_.makeOutput()) {
    input.targeted.assign(input.targeted.size(), true);
    for (int e = 0; e < robot_->effectorCount(); ++e) {
      input.targets.segment<3>(3 * e) = description.effectors[static_cast<std::size_t>(e)].point;
    }
  }

  void settle() { ASSERT_GE(sinew::settle(controller_, input, output, 1e-10, 800), 0); }
  CycleStatus step() { return controller_.step(input, output); }
  double calcError(int effector) const {
    return (output.effectors - input.targets).segment<2>(3 * effector + 1).norm();  // y and z
  }

 private:
  std::shared_ptr<const RobotModel> robot_;
  InverseController controller_;

 public:
  CycleInput input;
  CycleOutput output;
};

/// Half way to what the tip alone reaches and where the middle does not want to be.
void askForBoth(HeldBar& run) {
  run.input.targets.segment<3>(3 * kTip) += Vec3(0, 0.003, 0.004);
  run.input.targets.segment<3>(3 * kMiddle) += Vec3(0, -0.004, -0.004);
}

TEST(Hold, TheTipComesFirst) {
  HeldBar wish(makeDescription(false)), hold(makeDescription(true));
  askForBoth(wish);
  askForBoth(hold);
  wish.settle();
  hold.settle();
  EXPECT_GT(wish.calcError(kTip), 5e-4);
  EXPECT_LT(hold.calcError(kTip), 1e-8);
  EXPECT_EQ(hold.output.status, CycleStatus::kSolved);
  EXPECT_GT(hold.calcError(kMiddle), wish.calcError(kMiddle)) << "it gets what is left";
}

// What is left is spent as well as can be: no neighbouring target of the tip serves the middle as well.
TEST(Hold, TheOthersGetTheRest) {
  RobotDescription heavy = makeDescription(false);
  heavy.effectors[kTip].weight = 30;
  HeldBar hold(makeDescription(true)), weighed(heavy);
  askForBoth(hold);
  askForBoth(weighed);
  hold.settle();
  weighed.settle();
  EXPECT_NEAR(hold.calcError(kMiddle), weighed.calcError(kMiddle), 2e-5);
}

TEST(Hold, ItHoldsAgainstAnObstacle) {
  HeldBar hold(makeDescription(true, {makeCylinder(0.01, Vec3(0.05, 0.01, 0.033))}));
  hold.settle();
  for (int k = 0; k < 150; ++k) {
    const double depth = 3e-5 * k;  // m, that the post has come down
    hold.input.obstacles = {
        {Pose(Eigen::Translation3d(0.05, 0.01, 0.033 - depth) * Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX())), true}};
    ASSERT_EQ(hold.step(), CycleStatus::kSolved) << k;
    EXPECT_LT(hold.calcError(kTip), 2e-5) << k;
  }
  hold.settle();
  EXPECT_GT(hold.output.contacts.force.head(hold.output.contacts.count).maxCoeff(), 0.01);
  EXPECT_LT(hold.calcError(kTip), 1e-8);
  EXPECT_GT(hold.calcError(kMiddle), 1e-3);
}

TEST(Hold, WhatCannotBeHeldIsTheStrongestWish) {
  for (const bool touching : {false, true}) {
    std::vector<ObstacleDescription> obstacles;
    if (touching) obstacles.push_back(makeCylinder(0.01, Vec3(0.05, 0.01, 0.033)));
    RobotDescription description = makeDescription(true, obstacles), single = description;
    single.effectors.pop_back();
    HeldBar hold(description), alone(single);
    for (HeldBar* run : {&hold, &alone}) {
      run->input.targets[2] += 0.2;  // out of reach
      for (int k = 0; k < 400; ++k) ASSERT_NE(run->step(), CycleStatus::kHeld) << k;
    }
    EXPECT_EQ(hold.output.status, CycleStatus::kDegraded);
    EXPECT_NEAR(hold.calcError(kTip), alone.calcError(kTip), 0.01 * alone.calcError(kTip));
    hold.input.targets[2] -= 0.2;
    hold.settle();
    EXPECT_EQ(hold.output.status, CycleStatus::kSolved);
    EXPECT_LT(hold.calcError(kTip), 1e-8);
  }
}

}  // namespace
}  // namespace sinew
