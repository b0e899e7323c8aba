#include "check_line.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

const Vec3 kTarget(0.03, -0.02, 0.185);

CycleOutput settledOutput(const RobotDescription& description, double period, double seconds) {
  InverseController controller(makeRobot(description));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  input.targets.head<3>() = kTarget;
  input.period = period;
  for (int k = 0; k < static_cast<int>(seconds / period); ++k) {
    EXPECT_NE(controller.step(input, output), CycleStatus::kHeld);
  }
  return output;
}

TEST(Settling, ImbalanceVanishesAtAFixedTarget) {
  const CycleOutput output = settledOutput(readShippedRobot("trunk"), 0.01, 3);
  checkFigure("settling.residual", output.residual_relative, "<=", 1e-8, "1");
}

TEST(Settling, DoesNotDependOnThePeriodOrTheModel) {
  RobotDescription description = readShippedRobot("trunk");
  const CycleOutput reference = settledOutput(description, 0.01, 3);
  const double size = reference.displacement.norm();
  double worst_static = 0, worst_dynamic = 0;
  for (double rate : {50.0, 200.0}) {
    const CycleOutput output = settledOutput(description, 1 / rate, 3);
    worst_static = std::max(worst_static, (output.displacement - reference.displacement).norm() / size);
  }
  description.control.model = MotionModel::kDynamic;
  for (double rate : {50.0, 100.0, 200.0}) {
    const CycleOutput output = settledOutput(description, 1 / rate, 4);
    worst_dynamic = std::max(worst_dynamic, (output.displacement - reference.displacement).norm() / size);
  }
  checkFigure("period_independence.static", worst_static, "<=", 1e-6, "1");
  checkFigure("period_independence.dynamic", worst_dynamic, "<=", 1e-6, "1");
}

}  // namespace
}  // namespace sinew
