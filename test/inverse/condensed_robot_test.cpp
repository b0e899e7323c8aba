#include "sinew/inverse/condensed_robot.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "body/energy.h"
#include "inverse/bar_robot.h"
#include "sinew/constraint/cable.h"
#include "sinew/constraint/point_effector.h"

namespace sinew {
namespace {

class CondensedRobotTest : public testing::Test {
 protected:
  std::mt19937 random{1};
  StageTimes times;

  static RobotDescription makeDescription() {
    RobotDescription description = makeBarDescription();
    description.cables[2].tube_stiffness = 50;
    description.effectors.emplace_back();
    description.effectors[1].point = Vec3(0.05, 0.01, 0.01);
    description.effectors[1].axes = {{false, true, true}};
    description.effectors[1].weight = 3;
    return description;
  }

  std::shared_ptr<const RobotModel> robot = makeBarRobot(makeDescription());
  CondensedRobot condensed{robot};
  const FemModel& fem = robot->fem();

  VecX makeRandom(int size, double min, double max) {
    std::uniform_real_distribution<double> uniform(min, max);
    VecX x(size);
    for (int i = 0; i < size; ++i) x[i] = uniform(random);
    return x;
  }

  std::vector<Vec3> makeDeformed(double stretch) {
    std::vector<Vec3> positions = fem.rest();
    for (int node : fem.freeNodes()) {
      positions[node].x() *= stretch;
      positions[node] += makeRandom(3, -2e-4, 2e-4);
    }
    return positions;
  }

  /// Actuators first, then effectors, at the present configuration.
  MatX makeDenseRows() const {
    ConstraintRows rows(fem, 20, 1000);
    for (const Cable& cable : robot->cables()) cable.addRow(condensed.body().positions(), rows);
    for (const PointEffector& effector : robot->effectors()) effector.addRows(rows);
    MatX H(rows.rows(), fem.size());
    for (int i = 0; i < rows.rows(); ++i) {
      VecX row = VecX::Zero(fem.size());
      rows.addTransposed(i, 1, row);
      H.row(i) = row;
    }
    return H;
  }

  /// Elastic, tube, gravity and cable forces of the present configuration [N].
  VecX calcForces(const VecX& effort) const {
    const std::vector<Vec3>& positions = condensed.body().positions();
    const std::vector<Vec3> elastic = calcElasticForces(fem, positions);
    VecX force = makeDenseRows().topRows(robot->actuatorCount()).transpose() * effort;
    for (const Cable& cable : robot->cables()) cable.addTube(positions, &force, nullptr);
    for (int i = 0; i < fem.freeCount(); ++i) {
      force.segment<3>(3 * i) += elastic[fem.freeNodes()[i]] + fem.mass()[i] * robot->description().gravity;
    }
    return force;
  }
};

TEST_F(CondensedRobotTest, CountsActuatorsAndControlledAxes) {
  EXPECT_EQ(condensed.actuators(), 4);
  condensed.linearise(VecX::Zero(4), StepRule(), times);
  EXPECT_EQ(condensed.rows(), 4 + 3 + 2);
}

TEST_F(CondensedRobotTest, TakesItsRuleFromTheDescription) {
  EXPECT_FALSE(condensed.makeRule(0.02).dynamic);
  RobotDescription description = makeDescription();
  description.control.model = MotionModel::kDynamic;
  description.damping_mass = 2;
  description.damping_stiffness = 0.03;
  const StepRule rule = CondensedRobot(makeBarRobot(description)).makeRule(0.02);
  EXPECT_TRUE(rule.dynamic);
  EXPECT_EQ(rule.period, 0.02);
  EXPECT_EQ(rule.damping_mass, 2);
  EXPECT_EQ(rule.damping_stiffness, 0.03);
}

TEST_F(CondensedRobotTest, CondensesAsTheDenseInverseDoes) {
  for (const StepRule& rule : {StepRule(), StepRule{true, 0.01, 2, 0.02}}) {
    condensed.body().place(makeDeformed(1.05));
    condensed.linearise(makeRandom(4, 0, 3), rule, times);
    const MatX A = condensed.body().matrix().makeDense();
    const VecX b = condensed.body().load();
    ASSERT_TRUE(condensed.factorise(times));
    condensed.condense(times);
    const MatX H = makeDenseRows();
    const MatX W = H * A.llt().solve(H.transpose());
    const VecX free = H * A.llt().solve(b);
    EXPECT_LT((condensed.compliance() - W).norm(), 1e-9 * W.norm());
    EXPECT_LT((condensed.freeMotion() - free).norm(), 1e-9 * free.norm());
  }
}

TEST_F(CondensedRobotTest, SystemIsTheDerivativeOfAllItsForces) {
  const std::vector<Vec3> positions = makeDeformed(1.05);
  const VecX effort = makeRandom(4, 0, 3);
  condensed.body().place(positions);
  condensed.linearise(effort, StepRule(), times);
  const MatX A = condensed.body().matrix().makeDense();
  constexpr double kStep = 1e-7;  // m
  for (int k = 0; k < fem.size(); k += 5) {
    std::vector<Vec3> moved = positions;
    moved[fem.freeNodes()[k / 3]][k % 3] += kStep;
    condensed.body().place(moved);
    const VecX above = calcForces(effort);
    moved[fem.freeNodes()[k / 3]][k % 3] -= 2 * kStep;
    condensed.body().place(moved);
    const VecX column = (calcForces(effort) - above) / (2 * kStep);
    EXPECT_LT((A.col(k) - column).norm(), 1e-6 * A.col(k).norm());
  }
}

TEST_F(CondensedRobotTest, ReportsItsPresentValues) {
  const VecX effort = makeRandom(4, 0, 3);
  condensed.body().place(makeDeformed(0.95));
  condensed.linearise(effort, StepRule(), times);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(condensed.displacement()[i], robot->cables()[i].calcDisplacement(condensed.body().positions()));
  }
  const VecX imbalance = calcForces(effort);
  EXPECT_NEAR(condensed.residual(), imbalance.norm(), 1e-9 * imbalance.norm());
  EXPECT_LT((condensed.body().load() - imbalance).norm(), 1e-9 * imbalance.norm());
  const VecX cables = makeDenseRows().topRows(4).transpose() * effort;
  EXPECT_NEAR(condensed.loadNorm(), condensed.body().gravityForce().norm() + cables.norm(), 1e-12);
}

TEST_F(CondensedRobotTest, AdvancesByTheLinearMotion) {
  const std::vector<Vec3> positions = makeDeformed(1);
  condensed.body().place(positions);
  condensed.linearise(VecX::Ones(4), StepRule(), times);
  const MatX A = condensed.body().matrix().makeDense();
  const VecX b = condensed.body().load();
  ASSERT_TRUE(condensed.factorise(times));
  condensed.condense(times);
  const VecX change = makeRandom(4, -0.5, 2);
  const VecX expected = A.llt().solve(b + makeDenseRows().topRows(4).transpose() * change);
  double longest = 0;
  for (int i = 0; i < fem.freeCount(); ++i) longest = std::max(longest, expected.segment<3>(3 * i).norm());
  for (double limit : {1.0, longest / 3}) {
    condensed.body().place(positions);
    const double scale = condensed.advance(change, VecX(), limit, times);
    EXPECT_NEAR(scale, std::min(1.0, limit / longest), 1e-9);
    for (int i = 0; i < fem.freeCount(); ++i) {
      const int node = fem.freeNodes()[i];
      const Vec3 way = condensed.body().positions()[node] - positions[node];
      EXPECT_LT((way - scale * expected.segment<3>(3 * i)).norm(), 1e-9 * longest);
    }
  }
}

// Pressed to 70 % of its length the body would buckle: the exact tangent has lost its definiteness.
TEST_F(CondensedRobotTest, CondensesNearBucklingWithTheSemidefiniteTangent) {
  condensed.body().place(makeDeformed(0.7));
  condensed.linearise(VecX::Zero(4), StepRule(), times);
  const Eigen::SelfAdjointEigenSolver<MatX> exact(condensed.body().matrix().makeDense(), Eigen::EigenvaluesOnly);
  ASSERT_LT(exact.eigenvalues().minCoeff(), 0);
  ASSERT_TRUE(condensed.factorise(times));
  condensed.condense(times);
  const MatX A = condensed.body().matrix().makeDense();
  const MatX H = makeDenseRows();
  const MatX W = H * A.llt().solve(H.transpose());
  EXPECT_LT((condensed.compliance() - W).norm(), 1e-8 * W.norm());
  EXPECT_LT((condensed.body().load() - calcForces(VecX::Zero(4))).norm(), 1e-9 * condensed.residual());
}

TEST_F(CondensedRobotTest, ResetReturnsToRest) {
  condensed.body().place(makeDeformed(1.1));
  condensed.reset();
  EXPECT_EQ(condensed.body().positions(), fem.rest());
}

}  // namespace
}  // namespace sinew
