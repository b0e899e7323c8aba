// Obstacles that move at 0.1 m/s, seen 100 times a second: they push the robot, pass along it, and come at it from
// ahead, while it holds its tip or follows a path. The real surface stays out of them, in every cycle.

#include <algorithm>
#include <cmath>

#include "inverse/contact_checks.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.01;        // s
constexpr double kSpeed = 0.1;          // m/s, of obstacles
constexpr double kLargestDepth = 2e-4;  // m

std::shared_ptr<const RobotModel> makeRobotWith(const std::string& name, DetectionMethod method) {
  RobotDescription description = readShippedRobot(name);
  description.contacts.method = method;
  return makeRobot(description);
}

/// A run of the controller against one moving obstacle.
struct Passage {
  std::shared_ptr<const RobotModel> robot;
  InverseController controller{robot};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  ContactWatch watch{controller};
  Pose waiting = robot->obstacles()[0].pose;

  explicit Passage(std::shared_ptr<const RobotModel> model) : robot(std::move(model)) {
    controller.resynchronise(VecX::Zero(robot->actuatorCount()));
    input.targeted[0] = true;
    input.targets.head<3>() = robot->description().effectors[0].point;
    input.obstacles = {{waiting, true}};
  }

  /// Moves the obstacle straight to `goal`, relative to where it waits [m].
  void moveTo(const Vec3& goal) {
    const Vec3 start = input.obstacles[0].pose.translation(), end = waiting.translation() + goal;
    const int cycles = static_cast<int>(std::ceil((end - start).norm() / (kSpeed * kPeriod)));
    for (int k = 1; k <= cycles; ++k) {
      input.obstacles[0].pose.translation() = start + (end - start) * k / cycles;
      cycle();
    }
  }
  void place(const Vec3& offset) { input.obstacles[0].pose.translation() = waiting.translation() + offset; }
  void wait(int cycles) {
    for (int k = 0; k < cycles; ++k) cycle();
  }
  void cycle() {
    controller.step(input, output);
    watch.add(input, output);
  }
};

class Penetration : public testing::TestWithParam<DetectionMethod> {
 protected:
  static std::string name(const std::string& scene) {
    return scene + (GetParam() == DetectionMethod::kProximity ? "" : "_volume");
  }
};

TEST_P(Penetration, APostIsPushedAgainstTheFinger) {
  Passage run(makeRobotWith("finger", GetParam()));
  run.moveTo(Vec3(0, -0.02, 0));
  run.wait(20);
  run.moveTo(Vec3::Zero());
  EXPECT_GT(run.watch.obstacleForce(), 0.1) << "N";
  run.watch.check(name("finger_push"), kLargestDepth);
}

// A goal that the post keeps out of reach: the command comes to rest all the same.
TEST_P(Penetration, TheFingerRestsBehindAPost) {
  Passage run(makeRobotWith("finger", GetParam()));
  run.moveTo(Vec3(0, -0.02, 0));
  run.wait(200);
  double step = 0;
  for (int k = 0; k < 100; ++k) {
    const VecX before = run.output.displacement;
    run.cycle();
    step = std::max(step, (run.output.displacement - before).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(run.output.effector_error, 1e-3) << "m: it is out of reach";
  const double noise = GetParam() == DetectionMethod::kProximity ? 5 : 50;  // pixels move the volumes
  checkFigure("penetration." + name("finger_behind_post_step"), 1e6 * step, "<=", noise, "um");
}

TEST_P(Penetration, APostPassesAlongTheFinger) {
  Passage run(makeRobotWith("finger", GetParam()));
  // Beside its stiff foot, between two ribs, one row for the whole overlap is too coarse.
  const double end = GetParam() == DetectionMethod::kProximity ? -0.04 : -0.02;
  run.place(Vec3(0, -0.012, 0.06));
  run.moveTo(Vec3(0, -0.012, end));
  run.moveTo(Vec3(0, -0.012, 0.06));
  EXPECT_GT(run.watch.obstacleForce(), 0.1) << "N";
  run.watch.check(name("finger_pass"), kLargestDepth);
}

TEST_P(Penetration, ACylinderIsPushedAgainstTheTrunk) {
  Passage run(makeRobotWith("trunk_cylinder", GetParam()));
  run.moveTo(Vec3(-0.034, 0, 0));
  run.wait(20);
  run.moveTo(Vec3::Zero());
  EXPECT_GT(run.watch.obstacleForce(), 0.1) << "N";
  run.watch.check(name("trunk_push"), kLargestDepth);
}

TEST_P(Penetration, ACylinderPassesAlongTheTrunk) {
  Passage run(makeRobotWith("trunk_cylinder", GetParam()));
  run.place(Vec3(-0.03, 0, 0.13));
  run.moveTo(Vec3(-0.03, 0, -0.05));
  run.moveTo(Vec3(-0.03, 0, 0.13));
  EXPECT_GT(run.watch.obstacleForce(), 0.1) << "N";
  run.watch.check(name("trunk_pass"), kLargestDepth);
}

INSTANTIATE_TEST_SUITE_P(Methods, Penetration, testing::Values(DetectionMethod::kProximity, DetectionMethod::kVolume));

// The trunk curled up until its inner side lies in folds. Farther round, its coarse mesh creases within neighbouring
// faces, which no contact sees.
TEST(PenetrationOfItself, TheTrunkCurlsUp) {
  constexpr double kCurl = 1.95;  // rad
  RobotDescription description = readShippedRobot("trunk");
  description.contacts.self = true;
  const auto robot = makeRobot(description);
  InverseController controller(robot);
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  ContactWatch watch(controller);
  input.targeted[0] = true;
  for (int k = 1; k <= 250; ++k) {
    const double angle = kCurl * std::min(1.0, k / 200.0);
    input.targets.head<3>() = 0.2 / angle * Vec3(1 - std::cos(angle), 0, std::sin(angle));
    controller.step(input, output);
    watch.add(input, output);
  }
  EXPECT_GT(watch.selfForce(), 0.05) << "N";
  watch.check("trunk_self", kLargestDepth);
}

}  // namespace
}  // namespace sinew
