#include <gtest/gtest.h>

#include "simulated_robot_node_plant.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

RobotDescription readTrunk() {
  return readRobotDescription(SINEW_SOURCE_DIR "/config/trunk/trunk.yaml");
}

VecX makePull(const RobotModel& robot) {
  VecX pull = VecX::Zero(robot.actuatorCount());
  pull[0] = 0.012;
  pull[5] = 0.004;
  return pull;
}

void stepUntilStill(const VecX& pull, SimulatedPlant& plant) {
  for (int step = 0; step < 60; ++step) plant.step(pull, 0.02);
}

TEST(SimulatedPlant, StepsComeToWhereTheForwardProblemSettles) {
  PlantDeviations deviations;
  deviations.stiffness_factor = 0.8;
  deviations.gravity_tilt = 0.1;
  deviations.cable_zero.assign(8, 0.0);
  deviations.cable_zero[2] = 0.003;
  SimulatedPlant plant(readTrunk(), deviations);
  const VecX pull = makePull(plant.robot());
  stepUntilStill(pull, plant);

  RobotDescription built = readTrunk();
  for (MaterialDescription& material : built.materials) material.young_modulus *= 0.8;
  built.gravity = Eigen::AngleAxisd(0.1, Vec3::UnitX()) * built.gravity;
  ForwardSimulator reference(std::make_shared<RobotModel>(built));
  Actuation actuation = reference.makeActuation();
  actuation.mode.assign(actuation.mode.size(), Actuation::Mode::kDisplacement);
  actuation.value = pull;
  actuation.value[2] += 0.003;
  reference.settle(actuation, 1e-9, 60);
  ASSERT_LT(reference.residualRelative(), 1e-9);
  EXPECT_LT((plant.simulator().effectors() - reference.effectors()).norm(), 1e-6);
  EXPECT_EQ(0u, plant.failedSteps());
}

// Without weight the shape depends on the cables alone, and their tension is proportional to the stiffness.
TEST(SimulatedPlant, TensionIsProportionalToStiffness) {
  RobotDescription weightless = readTrunk();
  weightless.gravity.setZero();
  PlantDeviations stiffer;
  stiffer.stiffness_factor = 1.7;
  SimulatedPlant plant(weightless, PlantDeviations()), stiff(weightless, stiffer);
  const VecX pull = makePull(plant.robot());
  stepUntilStill(pull, plant);
  stepUntilStill(pull, stiff);
  EXPECT_GT(plant.simulator().effort()[0], 0.1);
  EXPECT_LT((stiff.simulator().effort() - 1.7 * plant.simulator().effort()).norm(), 1e-3);
  EXPECT_LT((stiff.simulator().effectors() - plant.simulator().effectors()).norm(), 1e-5);
}

TEST(SimulatedPlant, ATiltKeepsTheWeight) {
  const RobotDescription drawn = readTrunk();
  PlantDeviations tilted;
  tilted.gravity_tilt = 0.3;
  const RobotDescription built = makeDeviated(drawn, tilted);
  EXPECT_NEAR(drawn.gravity.norm(), built.gravity.norm(), 1e-12);
  EXPECT_NEAR(std::cos(0.3), drawn.gravity.normalized().dot(built.gravity.normalized()), 1e-12);
}

// The cylinder's axis lies across the trunk's; the trunk is 16 mm thick beside it.
TEST(SimulatedPlant, AnObstaclePushesTheBodyAside) {
  SimulatedPlant plant(readRobotDescription(SINEW_SOURCE_DIR "/config/trunk_cylinder/trunk_cylinder.yaml"),
                       PlantDeviations());
  const double contact_distance = plant.robot().description().contacts.contact_distance;
  std::vector<ObstacleState> states{{plant.robot().obstacles()[0].pose, true}};
  const VecX slack = VecX::Zero(plant.robot().actuatorCount());
  const double rest = plant.simulator().effectors().x();
  for (double x = 0.04; x > 0.03; x -= 0.0005) {
    states[0].pose.translation().x() = x;
    plant.setObstacles(states);
    plant.step(slack, 0.01);
  }
  for (int step = 0; step < 20; ++step) plant.step(slack, 0.01);
  EXPECT_EQ(0u, plant.failedSteps());
  EXPECT_LT(plant.simulator().effectors().x(), rest - 0.005);
  EXPECT_GT(plant.simulator().contactForce().maxCoeff(), 0.05);
  const Vec3 axis = states[0].pose.linear().col(2);
  for (const Vec3& node : plant.simulator().nodes()) {
    const Vec3 arm = node - states[0].pose.translation();
    EXPECT_GT((arm - axis * axis.dot(arm)).norm(), 0.02 + 0.9 * contact_distance);
  }

  states[0].present = false;
  plant.setObstacles(states);
  for (int step = 0; step < 60; ++step) plant.step(slack, 0.01);
  EXPECT_NEAR(rest, plant.simulator().effectors().x(), 1e-4);
  EXPECT_EQ(0, plant.simulator().contacts().size());
}

TEST(SimulatedPlant, RefusesDeviationsThatMakeNoSense) {
  PlantDeviations wrong;
  wrong.stiffness_factor = 0;
  EXPECT_THROW(makeDeviated(readTrunk(), wrong), ConfigError);
  wrong = PlantDeviations();
  wrong.cable_zero.assign(3, 0.0);
  EXPECT_THROW(SimulatedPlant(readTrunk(), wrong), ConfigError);
}

}  // namespace
}  // namespace sinew
