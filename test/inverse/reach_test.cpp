#include "check_line.h"
#include "inverse/robots.h"
#include "sinew/constraint/cable.h"

namespace sinew {
namespace {

struct Reach {
  double settled_at = 0;           // s, from when on the commands stay within 1e-6 m over 200 cycles
  double displacement_excess = 0;  // m
  double tension_excess = 0;       // of the largest tension
  double alternation = 0;          // m, largest command step that reverses the one before while settled
};

// A target that no command can bring the tip to.
Reach chase(const RobotDescription& description, const Vec3& target) {
  constexpr int kCycles = 1500;
  constexpr int kWindow = 200;
  InverseController controller(makeRobot(description));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  input.targets.head<3>() = target;
  std::vector<VecX> commands;
  Reach reach;
  for (int k = 0; k < kCycles; ++k) {
    EXPECT_EQ(controller.step(input, output), CycleStatus::kSolved) << "cycle " << k;
    commands.push_back(output.displacement);
    for (int i = 0; i < output.displacement.size(); ++i) {
      const CableDescription& cable = controller.robot().cables()[i].description();
      reach.displacement_excess = std::max({reach.displacement_excess, output.displacement[i] - cable.displacement.max,
                                            cable.displacement.min - output.displacement[i]});
      reach.tension_excess = std::max({reach.tension_excess, (output.effort[i] - cable.tension.max) / cable.tension.max,
                                       (cable.tension.min - output.effort[i]) / cable.tension.max});
    }
  }
  int settled = kCycles;
  for (int k = kCycles - 1; k >= 0 && (commands[k] - commands.back()).cwiseAbs().maxCoeff() < 0.5e-6; --k) settled = k;
  reach.settled_at = kCycles - settled >= kWindow ? settled * input.period : std::nan("");
  for (int k = settled + 2; k < kCycles; ++k) {
    const VecX step = commands[k] - commands[k - 1], before = commands[k - 1] - commands[k - 2];
    if (step.dot(before) < 0) reach.alternation = std::max(reach.alternation, step.cwiseAbs().maxCoeff());
  }
  return reach;
}

class OutOfReach : public testing::TestWithParam<std::pair<std::string, Vec3>> {};

TEST_P(OutOfReach, SettlesWithinEveryLimit) {
  const auto& [name, target] = GetParam();
  const Reach reach = chase(readShippedRobot("trunk"), target);
  checkFigure("out_of_reach." + name + ".settled", reach.settled_at, "<=", 10, "s");
  checkFigure("out_of_reach." + name + ".displacement_excess", reach.displacement_excess, "<=", 1e-9, "m");
  checkFigure("out_of_reach." + name + ".tension_excess", reach.tension_excess, "<=", 1e-9, "1");
  checkFigure("out_of_reach." + name + ".alternation", reach.alternation, "<=", 1e-6, "m");
}

INSTANTIATE_TEST_SUITE_P(Targets, OutOfReach,
                         testing::Values(std::pair<std::string, Vec3>("sideways_0_5_m", Vec3(0.5, 0, 0.1)),
                                         std::pair<std::string, Vec3>("oblique_0_5_m", Vec3(0.3, 0.4, 0.2)),
                                         std::pair<std::string, Vec3>("sideways_10_m", Vec3(-10, 0, 0.1)),
                                         std::pair<std::string, Vec3>("oblique_10_m", Vec3(6, -8, 0)),
                                         std::pair<std::string, Vec3>("down_10_m", Vec3(0, 0, 10))));

}  // namespace
}  // namespace sinew
