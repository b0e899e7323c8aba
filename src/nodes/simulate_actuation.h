#pragma once

#include <memory>
#include <vector>

#include "simulate_obstacles.h"
#include "simulate_run.h"
#include "sinew/common/sampled_signal.h"
#include "sinew/inverse/actuation.h"

namespace sinew {

/// Displacements or efforts of the actuators over time.
struct ActuationSignal {
  std::vector<Actuation::Mode> mode;
  SampledSignal values;  ///< m or N, one per actuator
};

/// Columns `t` and displacement_NAME or effort_NAME of one or more actuators. The displacement counts where both are
/// given, as in a run; an actuator with neither keeps displacement 0. Throws ConfigError.
ActuationSignal readActuationSignal(const CsvTable& table, const RobotModel& robot);

/// The equilibrium of every row of the signal.
RunSummary settleActuation(std::shared_ptr<const RobotModel> robot, const ActuationSignal& signal,
                           const ObstacleSignal& obstacles, RunWriter& writer);

/// The signal through time, one row for each step of 1 / `rate`, from the equilibrium of its start.
RunSummary stepActuation(std::shared_ptr<const RobotModel> robot, const ActuationSignal& signal,
                         const ObstacleSignal& obstacles, double rate, RunWriter& writer);

}  // namespace sinew
