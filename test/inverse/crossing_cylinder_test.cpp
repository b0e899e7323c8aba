// The trunk's tip on a circle whose way a cylinder crosses, to and fro.

#include <algorithm>

#include "inverse/contact_checks.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.01;  // s
constexpr double kTurn = 8;       // s
constexpr int kTurns = 2;
constexpr double kHeight = 0.17;  // m, of the circle

/// A circle, and how far the cylinder comes across its way.
struct Crossing {
  int radius;    // mm
  double way;    // m, along x from where the cylinder waits
  double turns;  // to and fro in a turn of the circle
  double phase;  // rad of the circle, at which it waits
};

class CrossingCylinder : public testing::TestWithParam<Crossing> {
 protected:
  std::shared_ptr<const RobotModel> robot = makeRobot(readShippedRobot("trunk_cylinder"));
  InverseController controller{robot};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  ContactWatch watch{controller};

  CrossingCylinder() {
    controller.resynchronise(VecX::Zero(robot->actuatorCount()));
    input.targeted[0] = true;
    input.obstacles = {{robot->obstacles()[0].pose, true}};
  }

  /// Out to the circle in the first quarter of a turn.
  void aim(double time) {
    const double angle = 2 * M_PI * time / kTurn, grown = 1e-3 * GetParam().radius * std::min(1.0, 4 * time / kTurn);
    input.targets.head<3>() = Vec3(grown * std::cos(angle), grown * std::sin(angle), kHeight);
  }

  void cross(double time) {
    const double angle = GetParam().turns * 2 * M_PI * time / kTurn - GetParam().phase;
    input.obstacles[0].pose = robot->obstacles()[0].pose;
    input.obstacles[0].pose.translation().x() -= GetParam().way * 0.5 * (1 - std::cos(angle));
  }
};

TEST_P(CrossingCylinder, TheTipStaysOnItsCircle) {
  double sum = 0, worst = 0;
  int cycles = 0;
  for (int k = 0; k < kTurns * kTurn / kPeriod; ++k) {
    aim(k * kPeriod);
    cross(k * kPeriod);
    controller.step(input, output);
    watch.add(input, output);
    if (k * kPeriod < kTurn / 4) continue;
    sum += output.effector_error;
    worst = std::max(worst, output.effector_error);
    ++cycles;
  }
  const std::string name = "crossing_cylinder.radius_" + std::to_string(GetParam().radius) + "mm";
  checkFigure(name + "_mean", 1e3 * sum / cycles, "<=", 0.2, "mm");
  checkFigure(name + "_worst", 1e3 * worst, "<=", 2, "mm");
  checkFigure(name + "_held_cycles", watch.held(), "<=", 0, "1");
  checkFigure(name + "_depth", 1e3 * watch.depth(), "<=", 0.2, "mm");
  EXPECT_GT(watch.obstacleForce(), 0.3) << "N: the cylinder does push";
}

// On the wide circle the trunk would have to pass through the cylinder, were it not for the phase.
INSTANTIATE_TEST_SUITE_P(Circles, CrossingCylinder,
                         testing::Values(Crossing{30, 0.025, 3.2, 0}, Crossing{60, 0.04, 1, -0.8}));

}  // namespace
}  // namespace sinew
