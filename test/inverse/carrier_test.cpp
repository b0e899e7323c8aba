// A robot on a rail is the robot without one, with obstacles and targets moved the other way.

#include <gtest/gtest.h>

#include "inverse/contact_robot.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kTravel = 0.013;  // m

RobotDescription onRail(RobotDescription robot, const Vec3& axis) {
  robot.carrier.name = "rail";
  robot.carrier.axis = axis;
  robot.carrier.displacement = {-0.2, 0.2, 0.1};
  return robot;
}

Actuation withTravel(const ForwardSimulator& simulator, double travel) {
  Actuation actuation = simulator.makeActuation();
  actuation.value.head(4) << 0.002, 0.001, 0, 0;
  if (actuation.value.size() > 4) actuation.value[4] = travel;
  return actuation;
}

std::vector<ObstacleState> movedBack(const RobotDescription& robot, double travel) {
  std::vector<ObstacleState> states;
  for (const ObstacleDescription& obstacle : robot.obstacles) {
    states.push_back({Eigen::Translation3d(-travel * robot.carrier.axis.normalized()) * obstacle.pose, true});
  }
  return states;
}

double calcFarthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b, const Vec3& offset) {
  double farthest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) farthest = std::max(farthest, (a[i] - b[i] - offset).norm());
  return farthest;
}

class CarriedBar : public testing::Test {
 protected:
  Vec3 axis = Vec3(0.6, 0, -0.8);
  RobotDescription description = makeContactDescription({makeFloor(-0.014)});
  RobotDescription carried = onRail(description, axis);
};

TEST_F(CarriedBar, IsTheBarWithItsObstaclesMovedBack) {
  ForwardSimulator here(makeBarRobot(description)), there(makeBarRobot(carried));
  here.setObstacles(movedBack(carried, kTravel));
  ASSERT_EQ(here.settle(withTravel(here, 0)), ForwardStatus::kSolved);
  ASSERT_EQ(there.settle(withTravel(there, kTravel)), ForwardStatus::kSolved);
  ASSERT_GT(here.contactForce().sum(), 0.01) << "N: it lies on the floor";
  EXPECT_LT(calcFarthest(there.nodes(), here.nodes(), kTravel * axis), 1e-9);
  EXPECT_NEAR(there.contactForce().sum(), here.contactForce().sum(), 1e-6 * here.contactForce().sum());
  EXPECT_LT((there.effort().head(4) - here.effort()).norm(), 1e-6 * here.effort().norm());
  EXPECT_NEAR(there.displacement()[4], kTravel, 1e-12);
  for (int e = 0; e < 3; ++e) EXPECT_NEAR(there.effectors()[e], (here.effectors() + kTravel * axis)[e], 1e-9);
  std::vector<Vec3> points, carried_points;
  here.calcCablePoints(0, points);
  there.calcCablePoints(0, carried_points);
  EXPECT_LT(calcFarthest(carried_points, points, kTravel * axis), 1e-9);
}

TEST_F(CarriedBar, ItsDriveBearsWhatTheContactsAskFor) {
  ForwardSimulator simulator(makeBarRobot(carried));
  ASSERT_EQ(simulator.settle(withTravel(simulator, kTravel)), ForwardStatus::kSolved);
  double along = 0;
  for (int i = 0; i < simulator.contacts().size(); ++i) {
    along += simulator.contactForce()[i] * simulator.contacts().row(i).normal.dot(axis);
  }
  ASSERT_LT(along, -0.01);
  EXPECT_NEAR(simulator.effort()[4], -along, 1e-6);
}

TEST_F(CarriedBar, ItsRowsAreTheDerivatives) {
  const auto robot = makeBarRobot(carried);
  CondensedRobot condensed(robot);
  ContactFinder finder(*robot);
  StageTimes times;
  std::vector<ObstacleState> floor = {{Pose(Eigen::Translation3d(0, 0, -0.002)), true}};
  finder.setObstacles(floor);
  condensed.linearise(VecX::Zero(5), StepRule(), times);
  ASSERT_TRUE(condensed.factorise(times));
  finder.find(condensed.positions(), times);
  condensed.addContacts(finder);
  condensed.condense(times);
  ASSERT_GT(condensed.contacts(), 0);
  const auto W = condensed.compliance();
  EXPECT_LT((W - W.transpose()).norm(), 1e-14 * W.norm());
  const VecX ratio = W.col(4) / W(4, 4);  // of the motion of each row to the travel
  for (int i = 0; i < 4; ++i) EXPECT_EQ(ratio[i], 0);
  for (int e = 0; e < 3; ++e) EXPECT_NEAR(ratio[5 + e], axis[e], 1e-12);
  for (int i = 0; i < condensed.contacts(); ++i) {
    EXPECT_NEAR(ratio[condensed.firstContact() + i], finder.list().row(i).normal.dot(axis), 1e-12);
  }
}

TEST_F(CarriedBar, GoesWithItsTarget) {
  RobotDescription weightless = makeBarDescription();
  weightless.gravity.setZero();
  InverseController controller(makeBarRobot(onRail(weightless, Vec3::UnitX())));
  InverseController fixed(makeBarRobot(weightless));
  CycleInput input = controller.makeInput(), input_fixed = fixed.makeInput();
  CycleOutput output = controller.makeOutput(), output_fixed = fixed.makeOutput();
  input.targeted[0] = input_fixed.targeted[0] = true;
  input_fixed.targets.head<3>() = Vec3(0.098, 0.012, 0.008);
  const Vec3 far(0.05, 0, 0);
  input.targets.head<3>() = input_fixed.targets.head<3>() + far;
  double travelled = 0;
  for (int k = 0; k < 300; ++k) {
    ASSERT_EQ(controller.step(input, output), CycleStatus::kSolved);
    ASSERT_EQ(fixed.step(input_fixed, output_fixed), CycleStatus::kSolved);
    EXPECT_LE(std::abs(output.displacement[4] - travelled), 0.001 + 1e-12) << "rate";
    travelled = output.displacement[4];
  }
  EXPECT_LT(output.effector_error, 1e-8);
  EXPECT_LT(output.residual_relative, 1e-8);
  EXPECT_LT(output_fixed.effector_error, 1e-8);
  // Of all ways to get there, no less energy than with the rail's help.
  EXPECT_LT(output.effort.head(4).norm(), output_fixed.effort.norm());
}

TEST_F(CarriedBar, StopsAtTheEndOfItsRail) {
  RobotDescription robot = onRail(makeBarDescription(), Vec3::UnitX());
  robot.carrier.displacement.max = 0.02;
  InverseController controller(makeBarRobot(robot));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  input.targets.head<3>() = Vec3(0.2, 0.01, 0.01);
  for (int k = 0; k < 100; ++k) ASSERT_NE(controller.step(input, output), CycleStatus::kHeld);
  EXPECT_NEAR(output.displacement[4], 0.02, 1e-12);
  const auto reported = [&output] {
    return std::any_of(output.limits.begin(), output.limits.end(), [](const ActiveLimitReport& limit) {
      return limit.actuator == 4 && limit.kind == LimitKind::kDisplacementMax;
    });
  };
  EXPECT_TRUE(reported());
}

TEST_F(CarriedBar, GivesTravelAndPullsBack) {
  RobotDescription robot = withoutRates(carried);
  robot.effectors.push_back(robot.effectors[0]);
  robot.effectors[1].name = "middle";
  robot.effectors[1].point = Vec3(0.05, 0.018, 0.018);
  const auto model = makeBarRobot(robot);
  ForwardSimulator forward(model);
  const Actuation pulled = withTravel(forward, kTravel);
  ASSERT_EQ(forward.settle(pulled), ForwardStatus::kSolved);
  ASSERT_GT(forward.contactForce().sum(), 0.01);
  InverseController controller(model);
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted.assign(2, true);
  input.targets = forward.effectors();
  ASSERT_GE(settle(controller, input, output, 1e-12, 2000), 0);
  EXPECT_LT(output.effector_error, 1e-9);
  EXPECT_NEAR(output.displacement[4], kTravel, 1e-6);
}

TEST_F(CarriedBar, IsMovedToTheMeasurement) {
  InverseController controller(makeBarRobot(carried));
  VecX measured(5);
  measured << 0.001, 0.001, 0, 0, -0.04;
  EXPECT_LT(controller.resynchronise(measured), 1e-6);
  EXPECT_NEAR(controller.nodes()[0].x(), makeBarRobotMesh().nodes[0].x() - 0.04 * axis.x(), 1e-9);
}

// Steady acceleration a leaves the body where gravity g - a holds it.
TEST(CarriedDynamics, FeelsTheAcceleration) {
  constexpr double kPeriod = 0.01, kAcceleration = 1;
  RobotDescription robot = makeBarDescription();
  robot.control.model = MotionModel::kDynamic;
  robot.damping_mass = 20;
  RobotDescription leaning = robot;
  leaning.gravity -= kAcceleration * Vec3::UnitY();
  ForwardSimulator still(makeBarRobot(leaning)), moving(makeBarRobot(onRail(robot, Vec3::UnitY())));
  ASSERT_EQ(still.settle(withTravel(still, 0)), ForwardStatus::kSolved);
  double travel = 0;
  for (int k = 1; k <= 400; ++k) {
    travel = 0.5 * kAcceleration * std::pow(k * kPeriod, 2);
    ASSERT_EQ(moving.step(withTravel(moving, travel), kPeriod), ForwardStatus::kSolved);
    travel = moving.displacement()[4];
  }
  const double bent = (still.effectors().head<3>() - Vec3(0.1, 0.01, 0.01)).norm();
  ASSERT_GT(bent, 1e-4);
  EXPECT_LT((moving.effectors().head<3>() - travel * Vec3::UnitY() - still.effectors().head<3>()).norm(), 1e-4 * bent);
}

}  // namespace
}  // namespace sinew
