#include "sinew/inverse/inverse_controller.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "inverse/bar_robot.h"
#include "inverse/robots.h"
#include "sinew/constraint/cable.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

constexpr double kRounding = 1e-12;

RobotDescription makeDynamic(RobotDescription description) {
  description.control.model = MotionModel::kDynamic;
  description.damping_mass = 2;
  description.damping_stiffness = 0.02;
  return description;
}

VecX makeFour(double a, double b, double c, double d) {
  return Vec4(a, b, c, d);
}

/// Nodes and effector of a robot settled at given displacements.
struct Configuration {
  std::vector<Vec3> nodes;
  Vec3 effector;

  Configuration(const std::shared_ptr<const RobotModel>& robot, const VecX& displacement) {
    ForwardSimulator forward(robot);
    Actuation actuation = forward.makeActuation();
    actuation.value = displacement;
    EXPECT_EQ(forward.settle(actuation), ForwardStatus::kSolved);
    nodes = forward.nodes();
    effector = forward.effectors();
  }
};

class InverseControllerTest : public testing::Test {
 protected:
  const Limits range = makeBarDescription().cables[0].displacement;
  std::shared_ptr<const RobotModel> robot = makeBarRobot();
  Vec3 goal = Configuration(robot, makeFour(0.001, 0.003, 0.005, 0.004)).effector;
  InverseController controller{robot};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  double step = range.rate * input.period;  // m a cable may move in a cycle

  InverseControllerTest() { aimAt(goal); }

  void aimAt(const Vec3& target) {
    input.targeted[0] = true;
    input.targets = target;
  }

  void run(int cycles) {
    for (int k = 0; k < cycles; ++k) ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved) << "cycle " << k;
  }
};

/// Targets that jump within and far beyond what can be reached: no limit may ever be passed.
void expectLimitsKept(const std::shared_ptr<const RobotModel>& robot, const Vec3& centre) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  InverseController controller(robot);
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  VecX before = VecX::Zero(robot->actuatorCount());
  Vec3 target = centre;
  for (int cycle = 0; cycle < 300; ++cycle) {
    if (cycle % 20 == 0) target = centre + 0.03 * Vec3(uniform(random), uniform(random), uniform(random));
    if (cycle % 97 == 0) target *= 50;
    target += 5e-4 * Vec3(uniform(random), uniform(random), uniform(random));
    input.targets = target;
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld) << "cycle " << cycle;
    for (int i = 0; i < robot->actuatorCount(); ++i) {
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
  expectLimitsKept(makeRobot(readShippedRobot("accordion")), Vec3(0, 0, 0.05));
}

TEST(InverseController, KeepsThemInADynamicRobotToo) {
  expectLimitsKept(makeBarRobot(makeDynamic(makeBarDescription())), Vec3(0.09, 0.01, 0));
}

TEST_F(InverseControllerTest, BringsTheEffectorToItsTarget) {
  run(100);
  EXPECT_LT((output.effectors - goal).norm(), 1e-7);
  EXPECT_NEAR(output.effector_error, (output.effectors - goal).norm(), 1e-12);
  EXPECT_LT(output.residual_relative, 1e-7);
  EXPECT_EQ(output.reason, HoldReason::kNone);
  EXPECT_EQ(output.newton_steps, 1);
  EXPECT_EQ(output.goal_scale, 1);
}

// The command is the displacement that the model itself shows.
TEST_F(InverseControllerTest, CommandsWhatItsModelShows) {
  run(100);
  std::vector<Vec3> points;
  for (int i = 0; i < 4; ++i) {
    controller.calcCablePoints(i, points);
    double length = 0;
    for (std::size_t k = 1; k < points.size(); ++k) length += (points[k] - points[k - 1]).norm();
    EXPECT_NEAR(output.displacement[i], robot->cables()[i].restLength() - length, 1e-9);
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
  bad[4].applied = makeFour(0, std::nan(""), 0, 0);
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
  EXPECT_LT((output.effectors - goal).norm(), 1e-7);
}

TEST_F(InverseControllerTest, PreparedAheadItCommandsTheSame) {
  InverseController ahead{robot};
  CycleOutput prepared = ahead.makeOutput();
  for (int k = 0; k < 40; ++k) {
    if (k == 20) aimAt(goal + Vec3(0.002, -0.001, 0.003));
    ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved);

    ASSERT_EQ(ahead.step(input, prepared), CycleStatus::kSolved);
    EXPECT_LT((prepared.displacement - output.displacement).norm(), 1e-12) << k;
    EXPECT_EQ(prepared.times.factor == 0, k > 0) << k;
    const double before = prepared.times.cycle;
    ahead.prepare(prepared);
    EXPECT_GT(prepared.times.factor, 0);
    EXPECT_GT(prepared.times.cycle, before);
  }
}

// Whatever else moves the model between makes what was prepared worthless.
TEST_F(InverseControllerTest, ForgetsWhatWasPreparedWhenTheModelMoves) {
  const VecX elsewhere = makeFour(0.001, 0.004, 0.006, 0.002);
  const std::vector<std::function<void(InverseController&)>> moves = {
      [](InverseController& c) { c.reset(); }, [&](InverseController& c) { c.resynchronise(elsewhere); },
      [&](InverseController& c) {
        CycleOutput following = c.makeOutput();
        c.follow(elsewhere, 0.01, following);
      }};
  for (const auto& move : moves) {
    InverseController ahead{robot}, plain{robot};
    CycleOutput prepared = ahead.makeOutput();
    for (int k = 0; k < 15; ++k) {
      ahead.step(input, prepared);
      plain.step(input, output);
    }
    ahead.prepare(prepared);
    move(ahead);
    move(plain);
    ASSERT_NE(ahead.step(input, prepared), CycleStatus::kHeld);
    ASSERT_NE(plain.step(input, output), CycleStatus::kHeld);
    EXPECT_LT((prepared.displacement - output.displacement).norm(), 1e-9);
  }
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
  EXPECT_LT((output.effectors - goal).norm(), 1e-6);
}

TEST_F(InverseControllerTest, FreshControllerWithoutATargetStaysAtNoDisplacement) {
  input.targeted[0] = false;
  run(20);
  EXPECT_EQ(output.displacement, VecX::Zero(4));
}

TEST_F(InverseControllerTest, CountsRatesFromWhatWasApplied) {
  run(3);
  for (int k = 0; k < 30; ++k) {
    input.applied = 0.5 * output.displacement;
    const VecX applied = input.applied;
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
    EXPECT_LE((output.displacement - applied).cwiseAbs().maxCoeff(), step + kRounding);
  }
}

// A cable found outside its range returns into it at the rate, without a jump.
TEST_F(InverseControllerTest, ReturnsIntoItsRangeNoFasterThanTheRateAllows) {
  const VecX outside = VecX::Constant(4, range.min - 2.5 * step);
  ASSERT_LT(controller.resynchronise(outside), 1e-9);
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
  const VecX given = makeFour(0.001, 0.002, 0.006, 0.004);
  for (int k = 0; k < 60; ++k) ASSERT_EQ(controller.follow(given, input.period, output), CycleStatus::kSolved);
  EXPECT_EQ(output.displacement, given);
  EXPECT_LT((output.effectors - Configuration(robot, given).effector).norm(), 1e-8);
  EXPECT_EQ(controller.follow(VecX::Zero(2), input.period, output), CycleStatus::kHeld);
  EXPECT_EQ(controller.follow(makeFour(0, 0, 0, std::nan("")), input.period, output), CycleStatus::kHeld);
  EXPECT_EQ(output.displacement, given);
}

double worstNode(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}

TEST_F(InverseControllerTest, ResynchronisesToAMeasuredConfiguration) {
  run(20);  // somewhere else
  for (const VecX& measured :
       {makeFour(0.001, 0.005, 0.010, 0.002), makeFour(-0.01, -0.01, 0.004, 0.006), makeFour(0, 0, 0, 0)}) {
    EXPECT_LT(controller.resynchronise(measured), 1e-9);
    EXPECT_LT(worstNode(controller.nodes(), Configuration(robot, measured).nodes), 1e-6);
    ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
    EXPECT_LE((output.displacement - measured).cwiseAbs().maxCoeff(), step + kRounding);
  }
}

TEST(InverseController, ResynchronisesTheShippedAccordion) {
  const auto robot = makeRobot(readShippedRobot("accordion"));
  const Vec3 measured(0.005, 0.010, 0.015);
  InverseController controller(robot);
  EXPECT_LT(controller.resynchronise(measured), 1e-9);
  EXPECT_LT(worstNode(controller.nodes(), Configuration(robot, measured).nodes), 1e-6);
}

TEST(InverseController, ResynchronisesADynamicRobotAtRest) {
  InverseController controller(makeBarRobot(makeDynamic(makeBarDescription())));
  CycleOutput output = controller.makeOutput();
  const VecX measured = makeFour(0.001, 0.005, 0.010, 0.002);
  EXPECT_LT(controller.resynchronise(measured), 1e-9);
  const std::vector<Vec3> nodes = controller.nodes();
  for (int k = 0; k < 20; ++k) ASSERT_EQ(controller.follow(measured, 0.01, output), CycleStatus::kSolved);
  EXPECT_LT(worstNode(controller.nodes(), nodes), 1e-7);
}

TEST_F(InverseControllerTest, RefusesToResynchroniseToNonsense) {
  run(20);
  const std::vector<Vec3> nodes = controller.nodes();
  EXPECT_EQ(controller.resynchronise(VecX::Zero(2)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(controller.resynchronise(makeFour(0, std::nan(""), 0, 0)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(controller.nodes(), nodes);
}

TEST_F(InverseControllerTest, ResetForgetsEverything) {
  std::vector<VecX> commands;
  for (int k = 0; k < 30; ++k) {
    run(1);
    commands.push_back(output.displacement);
  }
  controller.reset();
  EXPECT_EQ(controller.nodes(), robot->fem().rest());
  for (const VecX& command : commands) {
    run(1);
    EXPECT_LT((output.displacement - command).norm(), 1e-12);
  }
}

TEST(InverseController, ReportsTheLimitsThatItSitsOn) {
  RobotDescription description = makeBarDescription();
  for (CableDescription& cable : description.cables) cable.displacement.max = 0.008;
  InverseController controller(makeBarRobot(description));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  input.targets = Vec3(0.02, 0.01, 0.01);  // far into the bar
  const auto expectReported = [&](LimitKind kind, double value, double at) {
    std::vector<bool> reported(4, false);
    for (const ActiveLimitReport& limit : output.limits) {
      EXPECT_EQ(limit.kind, kind);
      EXPECT_EQ(limit.value, value);
      EXPECT_EQ(limit.violation, 0);
      reported[limit.actuator] = true;
    }
    for (int i = 0; i < 4; ++i) EXPECT_EQ(reported[i], output.displacement[i] > at - 1e-10) << i;
    EXPECT_GE(output.limits.size(), 2U);
  };
  ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved);
  expectReported(LimitKind::kRateMax, 0.2, 0.2 * input.period);
  for (int k = 0; k < 100; ++k) ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved);
  expectReported(LimitKind::kDisplacementMax, 0.008, 0.008);
}

// A tension that no command within the range can hold: the tension gives way, and the cycle says so.
TEST(InverseController, DegradesWhereTensionAndDisplacementExcludeEachOther) {
  RobotDescription description = makeBarDescription();
  for (CableDescription& cable : description.cables) {
    cable.displacement = {-0.0001, 0.0001, 0.1};
    cable.tension = {5, 30, kUnlimited};
  }
  InverseController controller(makeBarRobot(description));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  input.targets = Vec3(0.1, 0.01, 0.01);
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
