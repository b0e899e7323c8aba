#include "sinew/inverse/inverse_controller.h"

#include <gtest/gtest.h>

#include <random>

#include "inverse/robots.h"
#include "sinew/constraint/cable.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

const Vec3 kTarget(0.004, -0.003, 0.055);  // m, within reach of the accordion
constexpr double kRounding = 1e-12;

std::shared_ptr<const RobotModel> accordion() {
  static const std::shared_ptr<const RobotModel> robot = makeRobot(readShippedRobot("accordion"));
  return robot;
}

std::shared_ptr<const RobotModel> dynamicAccordion() {
  RobotDescription description = readShippedRobot("accordion");
  description.control.model = MotionModel::kDynamic;
  return makeRobot(description);
}

class InverseControllerTest : public testing::Test {
 protected:
  InverseController controller{accordion()};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();

  InverseControllerTest() { aimAt(kTarget); }

  void aimAt(const Vec3& target) {
    input.targeted[0] = true;
    input.targets = target;
  }

  void run(int cycles) {
    for (int k = 0; k < cycles; ++k) ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved) << "cycle " << k;
  }
};

/// Targets that jump within and far beyond what can be reached: no limit may ever be passed.
void expectLimitsKept(const std::shared_ptr<const RobotModel>& robot) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  InverseController controller(robot);
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  VecX before = VecX::Zero(3);
  Vec3 target(0, 0, 0.06);
  for (int cycle = 0; cycle < 300; ++cycle) {
    if (cycle % 20 == 0) target = Vec3(0.03 * uniform(random), 0.03 * uniform(random), 0.05 + 0.03 * uniform(random));
    if (cycle % 97 == 0) target *= 50;
    target += 5e-4 * Vec3(uniform(random), uniform(random), uniform(random));
    input.targets = target;
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld) << "cycle " << cycle;
    for (int i = 0; i < 3; ++i) {
      const CableDescription& cable = robot->cables()[i].description();
      EXPECT_GE(output.displacement[i], cable.displacement.min);
      EXPECT_LE(output.displacement[i], cable.displacement.max);
      EXPECT_LE(std::abs(output.displacement[i] - before[i]), cable.displacement.rate * input.period + kRounding);
      if (output.status == CycleStatus::kDegraded) continue;
      EXPECT_GE(output.effort[i], cable.tension.min - 1e-8);
      EXPECT_LE(output.effort[i], cable.tension.max + 1e-8);
    }
    before = output.displacement;
  }
}

TEST(InverseController, KeepsEveryLimitAndRateWhateverTheTarget) {
  expectLimitsKept(accordion());
}

TEST(InverseController, KeepsThemInADynamicRobotToo) {
  expectLimitsKept(dynamicAccordion());
}

TEST_F(InverseControllerTest, BringsTheEffectorToItsTarget) {
  run(100);
  EXPECT_LT((output.effectors - kTarget).norm(), 1e-7);
  EXPECT_NEAR(output.effector_error, (output.effectors - kTarget).norm(), 1e-12);
  EXPECT_LT(output.residual_relative, 1e-7);
  EXPECT_EQ(output.reason, HoldReason::kNone);
  EXPECT_EQ(output.newton_steps, 1);
  EXPECT_EQ(output.goal_scale, 1);
}

// The command is the displacement that the model itself shows.
TEST_F(InverseControllerTest, CommandsWhatItsModelShows) {
  run(100);
  std::vector<Vec3> points;
  for (int i = 0; i < 3; ++i) {
    controller.calcCablePoints(i, points);
    double length = 0;
    for (std::size_t k = 1; k < points.size(); ++k) length += (points[k] - points[k - 1]).norm();
    EXPECT_NEAR(output.displacement[i], accordion()->cables()[i].restLength() - length, 1e-9);
  }
}

TEST_F(InverseControllerTest, HoldsTheLastCommandOnEveryBadInputAndRecovers) {
  run(60);
  const VecX command = output.displacement, effort = output.effort;
  const std::vector<Vec3> nodes = controller.nodes();
  const CycleInput good = input;
  std::vector<CycleInput> bad(9, good);
  bad[0].targets[1] = std::nan("");
  bad[1].targets[2] = std::numeric_limits<double>::infinity();
  bad[2].targets.resize(2);
  bad[3].targeted.clear();
  bad[4].applied = Vec3(0, std::nan(""), 0);
  bad[5].applied = VecX::Zero(2);
  bad[6].period = 0;
  bad[7].period = std::nan("");
  bad[8].targets[0] = -1e300;
  for (std::size_t k = 0; k < bad.size(); ++k) {
    EXPECT_EQ(controller.step(bad[k], output), CycleStatus::kHeld) << k;
    EXPECT_EQ(output.status, CycleStatus::kHeld);
    EXPECT_NE(output.reason, HoldReason::kNone);
    EXPECT_EQ(output.displacement, command) << k;
    EXPECT_EQ(output.effort, effort) << k;
    EXPECT_EQ(controller.nodes(), nodes) << "a hold keeps the body";
  }
  EXPECT_EQ(controller.step(good, output), CycleStatus::kSolved);
  EXPECT_EQ(output.reason, HoldReason::kNone);
  run(60);
  EXPECT_LT((output.effectors - kTarget).norm(), 1e-7);
}

TEST_F(InverseControllerTest, HoldsTheCablesWithoutATarget) {
  run(60);
  const VecX command = output.displacement;
  input.targeted[0] = false;
  for (int k = 0; k < 60; ++k) {
    ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved);
    EXPECT_EQ(output.displacement, command);
  }
  EXPECT_LT(output.residual_relative, 1e-8);
  EXPECT_LT((output.effectors - kTarget).norm(), 1e-6);
}

TEST_F(InverseControllerTest, FreshControllerWithoutATargetStaysAtNoDisplacement) {
  input.targeted[0] = false;
  run(20);
  EXPECT_EQ(output.displacement, VecX::Zero(3));
}

TEST_F(InverseControllerTest, CountsRatesFromWhatWasApplied) {
  run(3);
  const double step = accordion()->cables()[0].description().displacement.rate * input.period;
  for (int k = 0; k < 30; ++k) {
    input.applied = 0.5 * output.displacement;
    const VecX applied = input.applied;
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
    EXPECT_LE((output.displacement - applied).cwiseAbs().maxCoeff(), step + kRounding);
  }
}

// A cable found outside its range returns into it at the rate, without a jump.
TEST_F(InverseControllerTest, ReturnsIntoItsRangeNoFasterThanTheRateAllows) {
  const Limits& range = accordion()->cables()[0].description().displacement;
  const double step = range.rate * input.period;
  const Vec3 outside = Vec3::Constant(range.min - 2.5 * step);
  ASSERT_LT(controller.resynchronise(outside), 1e-6);
  VecX before = outside;
  for (int k = 0; k < 4; ++k) {
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
    EXPECT_LE((output.displacement - before).cwiseAbs().maxCoeff(), step + kRounding);
    EXPECT_GE(output.displacement.minCoeff(), std::min(range.min, before.minCoeff() + step) - kRounding);
    before = output.displacement;
  }
  EXPECT_GE(output.displacement.minCoeff(), range.min);
}

TEST_F(InverseControllerTest, FollowsGivenDisplacements) {
  const Vec3 given(0.004, 0.002, 0.006);
  for (int k = 0; k < 60; ++k) ASSERT_EQ(controller.follow(given, input.period, output), CycleStatus::kSolved);
  EXPECT_EQ(output.displacement, VecX(given));
  ForwardSimulator forward(accordion());
  Actuation actuation = forward.makeActuation();
  actuation.value = given;
  ASSERT_EQ(forward.settle(actuation), ForwardStatus::kSolved);
  EXPECT_LT((output.effectors - forward.effectors()).norm(), 1e-8);
  EXPECT_EQ(controller.follow(VecX::Zero(2), input.period, output), CycleStatus::kHeld);
  EXPECT_EQ(controller.follow(Vec3(0, 0, std::nan("")), input.period, output), CycleStatus::kHeld);
  EXPECT_EQ(output.displacement, VecX(given));
}

double worstNode(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}

TEST_F(InverseControllerTest, ResynchronisesToAMeasuredConfiguration) {
  ForwardSimulator forward(accordion());
  Actuation actuation = forward.makeActuation();
  run(20);  // somewhere else
  for (const Vec3& measured : {Vec3(0.005, 0.010, 0.015), Vec3(0.012, 0.004, 0.003), Vec3(0.002, 0.002, 0.002)}) {
    actuation.value = measured;
    ASSERT_EQ(forward.settle(actuation), ForwardStatus::kSolved);
    EXPECT_LT(controller.resynchronise(measured), 1e-9);
    EXPECT_LT(worstNode(controller.nodes(), forward.nodes()), 1e-6);
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
    const double step = accordion()->cables()[0].description().displacement.rate * input.period;
    EXPECT_LE((output.displacement - measured).cwiseAbs().maxCoeff(), step + kRounding);
  }
}

TEST(InverseController, ResynchronisesADynamicRobotAtRest) {
  const auto robot = dynamicAccordion();
  InverseController controller(robot);
  CycleOutput output = controller.makeOutput();
  const Vec3 measured(0.005, 0.010, 0.015);
  EXPECT_LT(controller.resynchronise(measured), 1e-9);
  const std::vector<Vec3> nodes = controller.nodes();
  for (int k = 0; k < 20; ++k) ASSERT_EQ(controller.follow(measured, 0.01, output), CycleStatus::kSolved);
  EXPECT_LT(worstNode(controller.nodes(), nodes), 1e-7);
}

TEST_F(InverseControllerTest, RefusesToResynchroniseToNonsense) {
  run(20);
  const std::vector<Vec3> nodes = controller.nodes();
  EXPECT_EQ(controller.resynchronise(VecX::Zero(2)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(controller.resynchronise(Vec3(0, std::nan(""), 0)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(controller.nodes(), nodes);
}

TEST_F(InverseControllerTest, ResetForgetsEverything) {
  std::vector<VecX> commands;
  for (int k = 0; k < 30; ++k) {
    run(1);
    commands.push_back(output.displacement);
  }
  controller.reset();
  EXPECT_EQ(controller.nodes(), accordion()->fem().rest());
  for (const VecX& command : commands) {
    run(1);
    EXPECT_LT((output.displacement - command).norm(), 1e-12);
  }
}

TEST_F(InverseControllerTest, ReportsTheLimitsThatItSitsOn) {
  aimAt(Vec3(0, 0, 0.001));
  controller.step(input, output);
  ASSERT_FALSE(output.limits.empty());
  for (const ActiveLimitReport& limit : output.limits) {
    EXPECT_EQ(limit.kind, LimitKind::kRateMax);
    EXPECT_EQ(limit.value, 0.1);
  }
  for (int k = 0; k < 200; ++k) ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
  std::vector<bool> reported(3, false);
  for (const ActiveLimitReport& limit : output.limits) {
    const CableDescription& cable = accordion()->cables()[limit.actuator].description();
    if (limit.kind == LimitKind::kDisplacementMax) {
      EXPECT_EQ(output.displacement[limit.actuator], cable.displacement.max);
    } else {
      EXPECT_EQ(limit.kind, LimitKind::kEffortMax);
      EXPECT_NEAR(output.effort[limit.actuator], cable.tension.max, 1e-6);
    }
    reported[limit.actuator] = true;
  }
  EXPECT_EQ(reported, std::vector<bool>(3, true));
}

// A tension that no command within the range can hold: the tension gives way, and the cycle says so.
TEST(InverseController, DegradesWhereTensionAndDisplacementExcludeEachOther) {
  RobotDescription description = readShippedRobot("accordion");
  for (CableDescription& cable : description.cables) {
    cable.displacement = {-0.0001, 0.0001, 0.1};
    cable.tension = {5, 30, kUnlimited};
  }
  InverseController controller(makeRobot(description));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  input.targets = kTarget;
  for (int k = 0; k < 50; ++k) {
    ASSERT_EQ(controller.step(input, output), CycleStatus::kDegraded);
    EXPECT_LE(output.displacement.cwiseAbs().maxCoeff(), 0.0001);
  }
  double violation = 0;
  for (const ActiveLimitReport& limit : output.limits) violation = std::max(violation, limit.violation);
  EXPECT_NEAR(violation, 5 - output.effort.minCoeff(), 1e-9);
  EXPECT_GT(violation, 1);
}

}  // namespace
}  // namespace sinew
