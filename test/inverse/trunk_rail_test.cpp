// The trunk on its rail is brought through between two cylinders (thesis Fig. 4.16).

#include <algorithm>

#include "check_line.h"
#include "inverse/contact_checks.h"
#include "inverse/robots.h"
#include "sinew/common/csv_table.h"
#include "sinew/common/sampled_signal.h"

namespace sinew {
namespace {

constexpr double kRate = 100;  // Hz

SampledSignal readPassage() {
  const CsvTable table = CsvTable::fromFile(std::string(SINEW_SOURCE_DIR) + "/config/trunk_rail/passage.csv");
  MatX points(3, table.rows());
  for (int axis = 0; axis < 3; ++axis) {
    points.row(axis) = table.numbers(std::string("target_tip_") + "xyz"[axis]).transpose();
  }
  return SampledSignal(table.risingNumbers("t"), points);
}

class TrunkOnRail : public testing::TestWithParam<DetectionMethod> {
 protected:
  static std::shared_ptr<const RobotModel> makeTrunk() {
    RobotDescription description = readShippedRobot("trunk_rail");
    description.contacts.method = GetParam();
    return makeRobot(description);
  }
  std::string scene() const { return GetParam() == DetectionMethod::kProximity ? "trunk_rail" : "trunk_rail_volume"; }
};

TEST_P(TrunkOnRail, PassesBetweenTheCylinders) {
  const auto robot = makeTrunk();
  InverseController controller(robot);
  controller.resynchronise(VecX::Zero(robot->actuatorCount()));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  const SampledSignal passage = readPassage();
  ContactWatch watch(controller);
  const int rail = robot->actuatorCount() - 1;
  double worst = 0, travel = 0, force = 0;
  VecX target(3);
  for (int k = 0; k < 22 * kRate; ++k) {
    passage.calcValue(k / kRate, target);
    input.targets.head<3>() = target;
    controller.step(input, output);
    watch.add(input, output);
    if (k > kRate) worst = std::max(worst, output.effector_error);  // the first second leads to the path
    travel = std::max(travel, output.displacement[rail]);
    force = std::max(force, output.contacts.force.head(output.contacts.count).sum());
  }
  EXPECT_GT(travel, 0.1) << "m: far into the gap";
  EXPECT_GT(force, 0.1) << "N: the cylinders are leant on";
  checkFigure(scene() + ".tip", 1e3 * worst, "<=", 1, "mm");
  watch.check(scene(), 0.0002);
}

INSTANTIATE_TEST_SUITE_P(Methods, TrunkOnRail, testing::Values(DetectionMethod::kProximity, DetectionMethod::kVolume));

}  // namespace
}  // namespace sinew
