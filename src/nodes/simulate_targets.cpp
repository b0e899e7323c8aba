#include "simulate_targets.h"

#include <algorithm>
#include <limits>

#include "sinew/common/config_error.h"
#include "sinew/constraint/point_effector.h"
#include "sinew/inverse/inverse_controller.h"

namespace sinew {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kEquilibrium = 1e-4;  // m of cable that the start may be off

std::string makeColumn(const EffectorDescription& effector, int axis) {
  return "target_" + effector.name + "_" + "xyz"[axis];
}

bool hasTarget(const CsvTable& table, const EffectorDescription& effector) {
  return table.has(makeColumn(effector, 0)) || table.has(makeColumn(effector, 1)) || table.has(makeColumn(effector, 2));
}

const char* nameOf(CycleStatus status) {
  switch (status) {
    case CycleStatus::kSolved:
      return "ok";
    case CycleStatus::kDegraded:
      return "degraded";
    default:
      return "held";
  }
}

/// Target columns as a run shows them: NaN where there is no target.
VecX calcShownTargets(const CycleInput& input) {
  VecX shown = input.targets;
  for (std::size_t e = 0; e < input.targeted.size(); ++e) {
    if (!input.targeted[e]) shown.segment<3>(3 * static_cast<Eigen::Index>(e)).setConstant(kNone);
  }
  return shown;
}

/// Mean distance of the targeted effectors [m] over their controlled axes.
double calcError(const RobotModel& robot, const CycleInput& input, const CycleOutput& output) {
  double sum = 0;
  int count = 0;
  for (int e = 0; e < robot.effectorCount(); ++e) {
    const auto index = static_cast<std::size_t>(e);
    if (!input.targeted[index]) continue;
    Vec3 difference = output.effectors.segment<3>(3 * e) - input.targets.segment<3>(3 * e);
    for (int axis = 0; axis < 3; ++axis) {
      if (!robot.description().effectors[index].axes[static_cast<std::size_t>(axis)]) difference[axis] = 0;
    }
    sum += difference.norm();
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

TargetSignal readTargetSignal(const CsvTable& table, const RobotModel& robot) {
  refuseUnknownColumns(table, robot);
  MatX positions(3 * robot.effectorCount(), table.rows());
  std::vector<bool> targeted;
  for (int e = 0; e < robot.effectorCount(); ++e) {
    const EffectorDescription& effector = robot.description().effectors[static_cast<std::size_t>(e)];
    targeted.push_back(hasTarget(table, effector));
    for (int axis = 0; axis < 3; ++axis) {
      const std::string column = makeColumn(effector, axis);
      const bool needed = targeted.back() && effector.axes[static_cast<std::size_t>(axis)];
      positions.row(3 * e + axis).setConstant(effector.point[axis]);
      if (needed || table.has(column)) positions.row(3 * e + axis) = table.numbers(column).transpose();
    }
  }
  if (std::find(targeted.begin(), targeted.end(), true) == targeted.end()) {
    throw ConfigError(table.name(), "no column target_NAME_x", "the targets of one effector of the robot or more");
  }
  return {SampledSignal(table.risingNumbers("t"), positions), targeted};
}

RunSummary simulateTargets(std::shared_ptr<const RobotModel> robot, const TargetSignal& targets,
                           const ObstacleSignal& obstacles, double rate, RunWriter& writer, ContactRecorder* recorder) {
  InverseController controller(robot);
  if (!(controller.resynchronise(VecX::Zero(robot->actuatorCount())) < kEquilibrium)) {
    throw ConfigError(robot->description().file, "no equilibrium with every cable at zero",
                      "materials and limits that hold the robot under gravity");
  }
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted = targets.targeted;
  input.period = 1 / rate;
  const VecX& times = targets.positions.times();
  const int cycles = countCycles(times[0], times[times.size() - 1], rate);
  RunSummary summary;
  RunProgress progress(cycles);
  for (int k = 0; k < cycles; ++k) {
    const double time = times[0] + k / rate;
    targets.positions.calcValue(time, input.targets);
    obstacles.calcStates(time, input.obstacles);
    const CycleStatus status = controller.step(input, output);
    writer.write({time, calcShownTargets(input), output.effectors, output.displacement, output.effort, nameOf(status),
                  output.residual, countPressing(output.contacts.force.head(output.contacts.count))});
    if (recorder) recorder->record(k, time, controller, output);
    summary.mean_error += calcError(*robot, input, output) / cycles;
    summary.not_ok += status != CycleStatus::kSolved;
    progress.update(++summary.rows);
  }
  return summary;
}

}  // namespace sinew
