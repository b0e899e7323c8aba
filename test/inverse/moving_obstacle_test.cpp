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

// The trunk, its tip held nearer to the base, bows towards a cylinder that pushes its middle through to the other side.
// A tracker sees the cylinder every other cycle, with noise: what that moves is no fault of the steps.
class PushedTrunk : public testing::TestWithParam<unsigned> {};

TEST_P(PushedTrunk, TheTipStaysWhateverTheTrackersNoise) {
  constexpr double kFrom = 0.0567, kWay = 0.04, kNoise = 0.0003;  // m
  const auto robot = makeRobot(readShippedRobot("trunk_cylinder"));
  InverseController controller(robot);
  controller.resynchronise(VecX::Zero(robot->actuatorCount()));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  const Mat3 turn = Eigen::AngleAxisd(M_PI / 4, Vec3::UnitZ()).toRotationMatrix();
  const Vec3 from = turn.col(0);  // half-way between two of the cables that reach the tip
  Pose pose = robot->obstacles()[0].pose;
  pose.linear() = turn * pose.linear();
  input.obstacles = {{pose, false}};
  input.targeted[0] = true;
  for (const double aside : {0.05, 0.0}) {
    input.targets.head<3>() = Vec3(0, 0, 0.18) - aside * from;
    for (int k = 0; k < 200; ++k) controller.step(input, output);
  }
  const auto middle = [&] { return output.effectors.segment<3>(3).dot(from); };
  const double bowed = middle();

  input.obstacles[0].present = true;
  std::mt19937 random(GetParam());
  std::normal_distribution<double> noise(0, kNoise);
  double worst = 0, pushed = 0;
  Vec3 off = Vec3::Zero();
  for (int k = 0; k < 360; ++k) {
    const double time = k / kRate;
    const double way = std::min(kSpeed * time, kWay) - std::max(0.0, kSpeed * (time - 1.8));
    for (int i = 0; i < 3 && k % 2 == 0; ++i) off[i] = noise(random);
    input.obstacles[0].pose.translation() = Vec3(0, 0, 0.09) + (kFrom - std::max(0.0, way)) * from + off;
    controller.step(input, output);
    worst = std::max(worst, output.effector_error);
    pushed = std::max(pushed, bowed - middle());
  }
  EXPECT_GT(pushed, kWay);
  checkFigure("moving_obstacle.noisy_push_tip", 1e3 * worst, "<=", 1.5, "mm");
}

INSTANTIATE_TEST_SUITE_P(Seeds, PushedTrunk, testing::Values(2u, 3u, 4u));

INSTANTIATE_TEST_SUITE_P(Methods, MovingObstacle,
                         testing::Values(DetectionMethod::kProximity, DetectionMethod::kVolume));

}  // namespace
}  // namespace sinew
