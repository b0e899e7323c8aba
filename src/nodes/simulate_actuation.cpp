#include "simulate_actuation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/common/config_error.h"
#include "sinew/inverse/forward_simulator.h"

namespace sinew {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kDisplacementStep = 5e-3;  // m between two equilibria on the way to a row
constexpr double kEffortStep = 1;           // N
constexpr double kWayTolerance = 1e-3, kRowTolerance = 1e-9;
constexpr int kNewtonSteps = 200;

const char* nameOf(ForwardStatus status) {
  switch (status) {
    case ForwardStatus::kSolved:
      return "ok";
    case ForwardStatus::kNotConverged:
      return "not_converged";
    default:
      return "failed";
  }
}

/// The forward simulator, and the rows that it leaves behind.
class ForwardRun {
 public:
  ForwardRun(std::shared_ptr<const RobotModel> robot, const ActuationSignal& signal, const ObstacleSignal& obstacles,
             RunWriter& writer)
      : simulator_(robot),
        writer_(&writer),
        signal_(&signal),
        obstacles_(&obstacles),
        actuation_{signal.mode, VecX::Zero(signal.values.size())} {
    row_.targets.setConstant(3 * robot->effectorCount(), kNone);
  }

  /// Equilibrium at `time`, over as many load steps as the way to it takes.
  ForwardStatus settle(double time) {
    placeObstacles(time);
    VecX goal;
    signal_->values.calcValue(time, goal);
    const VecX start = actuation_.value;
    const int steps = countLoadSteps(goal - start);
    for (int k = 1; k < steps; ++k) {
      actuation_.value = start + (goal - start) * k / steps;
      simulator_.settle(actuation_, kWayTolerance, kNewtonSteps);
    }
    actuation_.value = goal;
    return simulator_.settle(actuation_, kRowTolerance, kNewtonSteps);
  }

  ForwardStatus step(double time, double period) {
    placeObstacles(time);
    signal_->values.calcValue(time, actuation_.value);
    return simulator_.step(actuation_, period);
  }

  void write(double time, ForwardStatus status) {
    row_.time = time;
    row_.effectors = simulator_.effectors();
    row_.displacement = simulator_.displacement();
    row_.effort = simulator_.effort();
    row_.status = nameOf(status);
    row_.residual = simulator_.residual();
    row_.contacts = countPressing(simulator_.contactForce());
    writer_->write(row_);
    ++summary_.rows;
    summary_.not_ok += status != ForwardStatus::kSolved;
  }

  const RunSummary& summary() const { return summary_; }

 private:
  void placeObstacles(double time) {
    obstacles_->calcStates(time, states_);
    simulator_.setObstacles(states_);
  }

  int countLoadSteps(const VecX& change) const {
    double steps = 1;
    for (Eigen::Index i = 0; i < change.size(); ++i) {
      const bool displaced = actuation_.mode[static_cast<std::size_t>(i)] == Actuation::Mode::kDisplacement;
      steps = std::max(steps, std::abs(change[i]) / (displaced ? kDisplacementStep : kEffortStep));
    }
    return static_cast<int>(std::ceil(steps));
  }

  ForwardSimulator simulator_;
  RunWriter* writer_;
  const ActuationSignal* signal_;
  const ObstacleSignal* obstacles_;
  std::vector<ObstacleState> states_;
  Actuation actuation_;
  RunRow row_;
  RunSummary summary_;
};

}  // namespace

ActuationSignal readActuationSignal(const CsvTable& table, const RobotModel& robot) {
  refuseUnknownColumns(table, robot);
  std::vector<Actuation::Mode> mode;
  MatX values = MatX::Zero(robot.actuatorCount(), table.rows());
  bool any = false;
  for (const ActuatorLimits& actuator : robot.actuators()) {
    const auto row = static_cast<Eigen::Index>(mode.size());
    const bool displaced = table.has("displacement_" + actuator.name), pulled = table.has("effort_" + actuator.name);
    if (pulled && actuator.name == robot.description().carrier.name) {
      throw ConfigError(table.name(), "column effort_" + actuator.name,
                        "displacement_" + actuator.name + ": a carrier is driven to a place");
    }
    if (displaced || pulled) {
      values.row(row) = table.numbers((displaced ? "displacement_" : "effort_") + actuator.name).transpose();
    }
    mode.push_back(pulled && !displaced ? Actuation::Mode::kEffort : Actuation::Mode::kDisplacement);
    any = any || displaced || pulled;
  }
  if (!any) {
    throw ConfigError(table.name(), "no column displacement_NAME or effort_NAME",
                      "at least one for the robot's actuators");
  }
  return {mode, SampledSignal(table.risingNumbers("t"), values)};
}

RunSummary settleActuation(std::shared_ptr<const RobotModel> robot, const ActuationSignal& signal,
                           const ObstacleSignal& obstacles, RunWriter& writer) {
  ForwardRun run(robot, signal, obstacles, writer);
  RunProgress progress(signal.values.samples());
  for (int k = 0; k < signal.values.samples(); ++k) {
    const double time = signal.values.times()[k];
    run.write(time, run.settle(time));
    progress.update(k + 1);
  }
  return run.summary();
}

RunSummary stepActuation(std::shared_ptr<const RobotModel> robot, const ActuationSignal& signal,
                         const ObstacleSignal& obstacles, double rate, RunWriter& writer) {
  ForwardRun run(robot, signal, obstacles, writer);
  const VecX& times = signal.values.times();
  const int cycles = countCycles(times[0], times[times.size() - 1], rate);
  RunProgress progress(cycles);
  run.write(times[0], run.settle(times[0]));
  for (int k = 1; k < cycles; ++k) {
    const double time = times[0] + k / rate;
    run.write(time, run.step(time, 1 / rate));
    progress.update(k + 1);
  }
  return run.summary();
}

}  // namespace sinew
