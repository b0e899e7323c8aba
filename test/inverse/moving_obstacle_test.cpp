// The trunk holds its tip still while a cylinder is pushed against it and drawn back (thesis Fig. 4.17), and while one
// comes and goes.

#include <algorithm>
#include <random>

#include "inverse/contact_checks.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kRate = 100;     // Hz
constexpr double kSpeed = 0.05;   // m/s
constexpr double kReach = 0.022;  // m, to where the cylinder touches, from where it waits
constexpr double kPush = 0.012;   // m, what the trunk can give way without moving its tip

class MovingObstacle : public testing::TestWithParam<DetectionMethod> {
 protected:
  std::shared_ptr<const RobotModel> robot = makeTrunk();
  InverseController controller{robot};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  Pose waiting = robot->obstacles()[0].pose;
  ContactWatch watch{controller};

  MovingObstacle() {
    controller.resynchronise(VecX::Zero(robot->actuatorCount()));
    input.targeted[0] = true;
    input.targets.head<3>() = Vec3(0, 0, 0.195);
    input.obstacles = {{waiting, true}};
  }

  static std::shared_ptr<const RobotModel> makeTrunk() {
    RobotDescription description = readShippedRobot("trunk_cylinder");
    description.contacts.method = GetParam();
    return makeRobot(description);
  }

  void cycle(double pushed) {
    input.obstacles[0].pose = waiting;
    input.obstacles[0].pose.translation().x() -= kReach + pushed;
    controller.step(input, output);
    watch.add(input, output);
  }

  std::string name(const std::string& part) const {
    return "moving_obstacle." + std::string(GetParam() == DetectionMethod::kProximity ? "proximity_" : "volume_") +
           part;
  }
};

TEST_P(MovingObstacle, TheTipStays) {
  double worst = 0, force = 0;
  for (int k = 0; k < 100; ++k) cycle(-0.01);
  for (int k = 0; k < 400; ++k) {
    const double time = k / kRate;
    cycle(std::min(kSpeed * time, kPush) - std::max(0.0, kSpeed * (time - 2)));
    worst = std::max(worst, output.effector_error);
    force = std::max(force, output.contacts.force.head(output.contacts.count).sum());
  }
  EXPECT_GT(force, 0.3) << "N: the cylinder does push";
  checkFigure(name("tip"), 1e3 * worst, "<=", 2, "mm");
  watch.check(GetParam() == DetectionMethod::kProximity ? "moving_proximity" : "moving_volume", 0.0002);
}

// An obstacle that appears in the middle of the body pushes it out, and nothing else happens.
TEST_P(MovingObstacle, ComesAndGoes) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.005, 0.02);
  for (int k = 0; k < 300; ++k) {
    if (k % 20 == 0) input.obstacles[0].present = !input.obstacles[0].present;
    const VecX before = output.displacement;
    cycle(place(random));
    ASSERT_TRUE(output.displacement.allFinite());
    EXPECT_TRUE(input.obstacles[0].present || output.contacts.count == 0);
    const double step = robot->description().cables[0].displacement.rate / kRate;
    EXPECT_LE(k == 0 ? 0 : (output.displacement - before).cwiseAbs().maxCoeff(), step * (1 + 1e-9));
  }
  checkFigure(name("coming_held_cycles"), watch.held(), "<=", 0, "1");
}

INSTANTIATE_TEST_SUITE_P(Methods, MovingObstacle,
                         testing::Values(DetectionMethod::kProximity, DetectionMethod::kVolume));

}  // namespace
}  // namespace sinew
