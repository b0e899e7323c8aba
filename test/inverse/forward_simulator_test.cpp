#include "sinew/inverse/forward_simulator.h"

#include <gtest/gtest.h>

#include "body/energy.h"
#include "inverse/bar_robot.h"
#include "sinew/constraint/cable.h"

namespace sinew {
namespace {

VecX makeFour(double a, double b, double c, double d) {
  return Vec4(a, b, c, d);
}

class ForwardSimulatorTest : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot = makeBarRobot();
  ForwardSimulator simulator{robot};
  Actuation actuation = simulator.makeActuation();

  void giveEfforts(const VecX& efforts) {
    actuation.mode.assign(4, Actuation::Mode::kEffort);
    actuation.value = efforts;
  }

  void giveDisplacements(const VecX& displacements) {
    actuation.mode.assign(4, Actuation::Mode::kDisplacement);
    actuation.value = displacements;
  }

  /// Elements, gravity and cables pull every free node to where it is.
  void expectEquilibrium(const ForwardSimulator& at) const {
    const FemModel& fem = robot->fem();
    const std::vector<Vec3> elastic = calcElasticForces(fem, at.nodes());
    ConstraintRows rows(fem, 4, 200);
    VecX force = VecX::Zero(fem.size());
    for (int i = 0; i < 4; ++i) {
      robot->cables()[i].addRow(at.nodes(), rows);
      rows.addTransposed(i, at.effort()[i], force);
    }
    for (int i = 0; i < fem.freeCount(); ++i) {
      force.segment<3>(3 * i) += elastic[fem.freeNodes()[i]] + fem.mass()[i] * robot->description().gravity;
    }
    EXPECT_LT(force.norm(), 1e-7);
  }
};

TEST_F(ForwardSimulatorTest, StartsAtRest) {
  EXPECT_EQ(simulator.nodes(), robot->fem().rest());
  EXPECT_EQ(simulator.effort(), VecX::Zero(4));
  EXPECT_LT(simulator.displacement().norm(), 1e-15);
  EXPECT_LT((simulator.effectors() - Vec3(0.1, 0.01, 0.01)).norm(), 1e-15);
  EXPECT_EQ(actuation.mode, std::vector<Actuation::Mode>(4, Actuation::Mode::kDisplacement));
  EXPECT_EQ(actuation.value, VecX::Zero(4));
}

TEST_F(ForwardSimulatorTest, GivenEffortsAct) {
  giveEfforts(makeFour(0.1, 0, 1.5, 1));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  EXPECT_EQ(simulator.effort(), actuation.value);
  EXPECT_LT(simulator.residualRelative(), 1e-9);
  EXPECT_GT(simulator.effectors()[2], 0.01) << "the upper cables bend it up";
  expectEquilibrium(simulator);
}

TEST_F(ForwardSimulatorTest, GivenDisplacementsAreReachedOrTheCableIsSlack) {
  giveDisplacements(makeFour(-0.015, -0.015, 0.008, 0.01));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  expectEquilibrium(simulator);
  for (int i : {2, 3}) {
    EXPECT_NEAR(simulator.displacement()[i], actuation.value[i], 1e-9);
    EXPECT_GT(simulator.effort()[i], 0.01);
  }
  for (int i : {0, 1}) {
    EXPECT_GT(simulator.displacement()[i], actuation.value[i] + 1e-4);
    EXPECT_NEAR(simulator.effort()[i], 0, 1e-12);
  }
}

TEST_F(ForwardSimulatorTest, EffortsAndDisplacementsAreTwoWaysToOneEquilibrium) {
  giveEfforts(makeFour(0.4, 0.8, 1.2, 0.6));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  const VecX efforts = actuation.value;
  ForwardSimulator other(robot);
  giveDisplacements(simulator.displacement());
  ASSERT_EQ(other.settle(actuation), ForwardStatus::kSolved);
  EXPECT_LT((other.effort() - efforts).norm(), 1e-5);
  for (std::size_t node = 0; node < other.nodes().size(); ++node) {
    EXPECT_LT((other.nodes()[node] - simulator.nodes()[node]).norm(), 1e-7);
  }
}

TEST_F(ForwardSimulatorTest, EffortsAndDisplacementsMix) {
  actuation.mode[0] = Actuation::Mode::kEffort;
  actuation.value = makeFour(0.3, -0.02, 0.006, 0.005);
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  expectEquilibrium(simulator);
  EXPECT_EQ(simulator.effort()[0], 0.3);
  EXPECT_NEAR(simulator.effort()[1], 0, 1e-12);
  EXPECT_NEAR(simulator.displacement()[2], 0.006, 1e-9);
}

TEST_F(ForwardSimulatorTest, StepsArriveWhereItSettles) {
  giveDisplacements(makeFour(-0.01, 0.002, 0.004, 0.003));
  for (int k = 0; k < 30; ++k) ASSERT_EQ(simulator.step(actuation, 0.01), ForwardStatus::kSolved);
  expectEquilibrium(simulator);
  ForwardSimulator settled(robot);
  ASSERT_EQ(settled.settle(actuation), ForwardStatus::kSolved);
  EXPECT_LT((simulator.effectors() - settled.effectors()).norm(), 1e-8);
}

TEST_F(ForwardSimulatorTest, StepsWithAnOlderFactorArriveThereToo) {
  ForwardSimulator reusing(robot, 4);
  for (const VecX& given : {makeFour(-0.01, 0.002, 0.004, 0.003), makeFour(0.004, 0.001, -0.01, 0.002)}) {
    giveDisplacements(given);
    for (int k = 0; k < 60; ++k) ASSERT_EQ(reusing.step(actuation, 0.01), ForwardStatus::kSolved);
    ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
    expectEquilibrium(reusing);
    EXPECT_LT((reusing.effectors() - simulator.effectors()).norm(), 1e-8);
    EXPECT_LT((reusing.effort() - simulator.effort()).norm(), 1e-5);
  }
}

TEST_F(ForwardSimulatorTest, AFactorThatIsNoneIsNeverUsedAgain) {
  ForwardSimulator reusing(robot, 1000);
  giveDisplacements(makeFour(0.002, std::nan(""), 0.002, 0.002));
  EXPECT_NE(reusing.step(actuation, 0.01), ForwardStatus::kSolved);
  giveDisplacements(makeFour(-0.004, 0.001, 0.002, 0.001));
  for (int k = 0; k < 100; ++k) ASSERT_EQ(reusing.step(actuation, 0.01), ForwardStatus::kSolved);
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  EXPECT_LT((reusing.effectors() - simulator.effectors()).norm(), 1e-7);
}

TEST_F(ForwardSimulatorTest, DynamicRobotComesToRestInTheSameEquilibrium) {
  giveEfforts(makeFour(0.1, 0.2, 0.5, 0.3));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  RobotDescription description = makeBarDescription();
  description.control.model = MotionModel::kDynamic;
  description.damping_mass = 5;
  description.damping_stiffness = 0.02;
  ForwardSimulator moving(makeBarRobot(description));
  ASSERT_EQ(moving.step(actuation, 0.005), ForwardStatus::kSolved);
  EXPECT_GT((moving.effectors() - simulator.effectors()).norm(), 1e-4) << "it takes its time";
  for (int k = 0; k < 300; ++k) ASSERT_EQ(moving.step(actuation, 0.02), ForwardStatus::kSolved);
  EXPECT_LT((moving.effectors() - simulator.effectors()).norm(), 1e-7);
}

TEST_F(ForwardSimulatorTest, RefusesWhatIsNoNumberAndStaysWhereItIs) {
  giveDisplacements(makeFour(-0.01, 0.002, 0.004, 0.003));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  const std::vector<Vec3> before = simulator.nodes();
  const VecX good = actuation.value;
  actuation.value[1] = std::nan("");
  EXPECT_EQ(simulator.step(actuation, 0.01), ForwardStatus::kNotFinite);
  EXPECT_EQ(simulator.settle(actuation), ForwardStatus::kNotFinite);
  EXPECT_EQ(simulator.nodes(), before);
  actuation.value = good;
  EXPECT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
}

// Rounding of the coordinates alone then leaves more than the tolerance of so small a load.
TEST_F(ForwardSimulatorTest, SettlesAStiffRobotOfLittleWeight) {
  RobotDescription description = makeBarDescription();
  description.materials[0].young_modulus = 1e9;
  description.materials[0].density = 1;
  ForwardSimulator stiff(makeBarRobot(description));
  actuation = stiff.makeActuation();
  EXPECT_EQ(stiff.settle(actuation, 1e-12), ForwardStatus::kSolved);
  EXPECT_GT(stiff.residualRelative(), 1e-12);
  EXPECT_LT(stiff.residualRelative(), 1e-7);
}

TEST_F(ForwardSimulatorTest, SaysThatItDidNotConverge) {
  giveDisplacements(makeFour(-0.01, -0.01, 0.01, 0.01));
  EXPECT_EQ(simulator.settle(actuation, 1e-9, 1), ForwardStatus::kNotConverged);
}

TEST_F(ForwardSimulatorTest, ResetReturnsToRest) {
  giveEfforts(makeFour(0.1, 0.2, 0.5, 0.3));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  const VecX reached = simulator.effectors();
  simulator.reset();
  EXPECT_EQ(simulator.nodes(), robot->fem().rest());
  EXPECT_EQ(simulator.effort(), VecX::Zero(4));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  EXPECT_LT((simulator.effectors() - reached).norm(), 1e-12);
}

TEST_F(ForwardSimulatorTest, ShowsItsCables) {
  giveEfforts(makeFour(0.1, 0.2, 0.5, 0.3));
  ASSERT_EQ(simulator.settle(actuation), ForwardStatus::kSolved);
  std::vector<Vec3> points;
  for (int i = 0; i < 4; ++i) {
    simulator.calcCablePoints(i, points);
    double length = 0;
    for (std::size_t k = 1; k < points.size(); ++k) length += (points[k] - points[k - 1]).norm();
    EXPECT_NEAR(robot->cables()[i].restLength() - length, simulator.displacement()[i], 1e-15);
  }
}

}  // namespace
}  // namespace sinew
