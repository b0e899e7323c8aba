#include "check_timing.h"

#include <cmath>

#include "sinew/inverse/inverse_controller.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr double kPeriod = 0.01;             // s
constexpr double kCyclesPerTurn = 200;
constexpr double kRadius = 0.02;  // of the robot's size
constexpr double kFree = 0.25;    // of a period

double calcSize(const TetMesh& mesh) {
  Vec3 lower = mesh.nodes.front(), upper = lower;
  for (const Vec3& node : mesh.nodes) {
    lower = lower.cwiseMin(node);
    upper = upper.cwiseMax(node);
  }
  return (upper - lower).norm();
}

}  // namespace

double CycleTiming::predictRate() const {
  return (1 - kFree) / cycle.calcQuantile(0.99);
}

CycleTiming timeCycles(std::shared_ptr<const RobotModel> robot, int cycles) {
  InverseController controller(robot);
  const bool rests = std::isfinite(controller.resynchronise(VecX::Zero(robot->actuatorCount())));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted.front() = true;
  input.period = kPeriod;
  CycleTiming timing;
  timing.rests = rests;
  timing.stages = {{"assembly", {}}, {"factor", {}}, {"compliance", {}}, {"quadratic programmes", {}}, {"advance", {}}};
  const double radius = kRadius * calcSize(robot->mesh());
  for (int k = 0; k < cycles; ++k) {
    const double angle = kTurn * k / kCyclesPerTurn;
    input.targets.head<3>() =
        robot->description().effectors.front().point + radius * Vec3(std::cos(angle), std::sin(angle), 0);
    timing.held += controller.step(input, output) == CycleStatus::kHeld;
    const StageTimes& times = output.times;
    const double seconds[] = {times.assembly, times.factor, times.compliance, times.qp, times.advance};
    for (std::size_t s = 0; s < timing.stages.size(); ++s) timing.stages[s].durations.add(seconds[s]);
    timing.cycle.add(times.cycle);
  }
  return timing;
}

}  // namespace sinew
