// An actuator whose displacement somebody else gives, among others that the controller moves.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "inverse/contact_robot.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kFree = std::numeric_limits<double>::quiet_NaN();

/// The bar under a post, which it leans on when its tip is asked to rise.
class ByHandTest : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot =
      makeBarRobot(makeContactDescription({makeCylinder(0.01, Vec3(0.06, 0.01, 0.0315))}));
  InverseController controller{robot};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();

  ByHandTest() {
    input.targeted[0] = true;
    input.targets = Vec3(0.097, 0.01, 0.018);
    input.by_hand = VecX::Constant(4, kFree);
  }

  /// Tip and contact forces of the robot settled at displacements.
  void expectEquilibrium() {
    ForwardSimulator forward(robot);
    Actuation actuation = forward.makeActuation();
    for (int k = 1; k <= 10; ++k) {
      actuation.value = output.displacement * k / 10;
      ASSERT_EQ(forward.settle(actuation, 1e-9, 500), ForwardStatus::kSolved);
    }
    EXPECT_LT((forward.effectors() - output.effectors).norm(), 1e-6);
    EXPECT_LT((forward.effort() - output.effort).norm(), 1e-3 * output.effort.norm());
  }
};

TEST_F(ByHandTest, TheOthersMakeTheBestOfIt) {
  ASSERT_GE(settle(controller, input, output, 1e-10, 500), 0);
  ASSERT_GT(output.contacts.force.maxCoeff(), 0.01) << "N: it leans on the post";
  const VecX alone = output.displacement;
  const double error = output.effector_error;

  InverseController guided(robot);
  input.by_hand[2] = alone[2];
  ASSERT_GE(settle(guided, input, output, 1e-10, 500), 0);
  EXPECT_LT((output.displacement - alone).cwiseAbs().maxCoeff(), 1e-5) << "the hand does what the controller would";
  EXPECT_NEAR(output.effector_error, error, 1e-6);

  input.by_hand[2] = alone[2] + 0.002;
  ASSERT_GE(settle(guided, input, output, 1e-10, 500), 0);
  EXPECT_EQ(output.displacement[2], alone[2] + 0.002);
  EXPECT_EQ(output.status, CycleStatus::kSolved);
  EXPECT_GT(output.contacts.force.maxCoeff(), 0.01);
  expectEquilibrium();
}

TEST_F(ByHandTest, ItFollowsTheHandInEveryCycle) {
  const double range = robot->description().cables[1].displacement.max;
  bool pressed = false;
  for (int k = 0; k < 300; ++k) {
    input.by_hand[2] = 0.3 * range * (1 - std::cos(0.05 * k));
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld) << k;
    EXPECT_EQ(output.displacement[2], input.by_hand[2]) << k;
    pressed =
        pressed || (output.contacts.count > 0 && output.contacts.force.head(output.contacts.count).maxCoeff() > 0);
    for (const ActiveLimitReport& limit : output.limits) {
      EXPECT_TRUE(limit.actuator != 2 || limit.kind == LimitKind::kEffortMin || limit.kind == LimitKind::kEffortMax);
    }
  }
  EXPECT_TRUE(pressed);
}

TEST_F(ByHandTest, TheHandKnowsNoRate) {
  const double leap = 5 * robot->description().cables[2].displacement.rate * input.period;
  input.by_hand[2] = leap;
  ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
  EXPECT_EQ(output.displacement[2], leap);
}

TEST_F(ByHandTest, ItFollowsWithoutTargetsToo) {
  input.targeted[0] = false;
  for (int k = 0; k <= 100; ++k) {
    input.by_hand[1] = 1e-4 * std::min(k, 50);
    ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved) << k;
    EXPECT_EQ(output.displacement[1], input.by_hand[1]);
  }
  EXPECT_GT(output.effort[1], 0.01);
  expectEquilibrium();
}

TEST_F(ByHandTest, WhatIsNotFiniteIsRefused) {
  ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
  const VecX before = output.displacement;
  input.by_hand[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(controller.step(input, output), CycleStatus::kHeld);
  EXPECT_EQ(output.reason, HoldReason::kNotFinite);
  EXPECT_EQ(output.displacement, before);
}

}  // namespace
}  // namespace sinew
