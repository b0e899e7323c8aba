#include <Eigen/SVD>

#include "check_line.h"
#include "inverse/robots.h"
#include "sinew/constraint/cable.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

struct RoundTrip {
  VecX applied;                                     // m, as the cables stand in the forward run
  VecX recovered;                                   // m
  VecX reached;                                     // m, effectors of the forward run
  VecX regained;                                    // m, effectors of the inverse run
  double applied_energy = 0, recovered_energy = 0;  // J, above the robot at rest under gravity
};

// Potential of gravity plus the elastic energy, summed over the elements as V (mu |F - R|^2 + lambda / 2 tr(R^T F -
// I)^2) with R from a singular value decomposition.
double potentialEnergy(const RobotModel& robot, const std::vector<Vec3>& nodes) {
  double energy = 0;
  for (const FemModel::Element& element : robot.fem().elements()) {
    TetGradients x;
    for (int a = 0; a < 4; ++a) x.col(a) = nodes[element.nodes[a]];
    const Mat3 F = x * element.shape.gradients.transpose();
    const Vec3 stretch = Eigen::JacobiSVD<MatX>(F).singularValues() - VecX::Ones(3);
    energy += element.shape.volume *
              (element.lame.mu * stretch.squaredNorm() + element.lame.lambda / 2 * stretch.sum() * stretch.sum());
  }
  for (int i = 0; i < robot.fem().freeCount(); ++i) {
    energy -= robot.fem().mass()[i] * robot.description().gravity.dot(nodes[robot.fem().freeNodes()[i]]);
  }
  return energy;
}

RoundTrip makeRoundTrip(const RobotDescription& description, const VecX& pulled, double tolerance) {
  const auto robot = makeRobot(description);
  RoundTrip result;
  ForwardSimulator forward(robot);
  Actuation actuation = forward.makeActuation();
  EXPECT_EQ(forward.settle(actuation, 1e-10), ForwardStatus::kSolved);
  const double rest_energy = potentialEnergy(*robot, forward.nodes());
  actuation.value = pulled;
  EXPECT_EQ(forward.settle(actuation, 1e-10), ForwardStatus::kSolved);
  result.applied = forward.displacement();
  result.reached = forward.effectors();
  result.applied_energy = potentialEnergy(*robot, forward.nodes()) - rest_energy;

  InverseController inverse(robot);
  CycleInput input = inverse.makeInput();
  CycleOutput output = inverse.makeOutput();
  input.targets = result.reached;
  input.targeted.assign(input.targeted.size(), true);
  EXPECT_GE(settle(inverse, input, output, tolerance, 5000), 0);
  for (int i = 0; i < robot->actuatorCount(); ++i) {
    const CableDescription& cable = robot->cables()[i].description();
    EXPECT_GE(output.displacement[i], cable.displacement.min - 1e-9);
    EXPECT_LE(output.displacement[i], cable.displacement.max + 1e-9);
    EXPECT_GE(output.effort[i], cable.tension.min - 1e-9 * cable.tension.max);
    EXPECT_LE(output.effort[i], cable.tension.max * (1 + 1e-9));
  }
  result.recovered = output.displacement;
  result.regained = output.effectors;
  result.recovered_energy = potentialEnergy(*robot, inverse.nodes()) - rest_energy;
  return result;
}

double worstRelative(const VecX& applied, const VecX& recovered) {
  return 100 * ((recovered - applied).array() / applied.array()).abs().maxCoeff();
}

TEST(RoundTrip, AccordionGivesItsCablesBack) {
  const RoundTrip trip = makeRoundTrip(readShippedRobot("accordion"), Vec3(0.005, 0.010, 0.015), 1e-11);
  checkFigure("round_trip_accordion.displacement", worstRelative(trip.applied, trip.recovered), "<=", 0.1, "%");
}

VecX pulledTrunk() {
  VecX pulled(8);
  pulled << 0.016, 0.012, 0.002, 0.005, 0.008, 0.006, 0.003, 0.004;
  return pulled;
}

TEST(RoundTrip, TrunkReachesTipAndMiddleAtNoMoreEnergy) {
  const RoundTrip trip = makeRoundTrip(readShippedRobot("trunk"), pulledTrunk(), 1e-9);
  checkFigure("round_trip_trunk.position", (trip.regained - trip.reached).cwiseAbs().maxCoeff(), "<=", 1e-6, "m");
  checkFigure("round_trip_trunk.energy", trip.recovered_energy / trip.applied_energy, "<=", 1, "1");
}

// Three points in each of two sections leave no freedom: the cables must come back themselves.
TEST(RoundTrip, TrunkWithEighteenRowsGivesItsCablesBack) {
  RobotDescription description = readShippedRobot("trunk");
  description.effectors.clear();
  for (double z : {0.1, 0.19}) {
    for (int k = 0; k < 3; ++k) {
      EffectorDescription effector;
      effector.name = "point_" + std::to_string(description.effectors.size());
      const double angle = 2 * M_PI * k / 3;
      effector.point = Vec3(0.008 * std::cos(angle), 0.008 * std::sin(angle), z);
      description.effectors.push_back(effector);
    }
  }
  const RoundTrip trip = makeRoundTrip(description, pulledTrunk(), 1e-11);
  checkFigure("round_trip_trunk.displacement", worstRelative(trip.applied, trip.recovered), "<=", 1, "%");
}

}  // namespace
}  // namespace sinew
