#pragma once

#include <memory>
#include <vector>

#include "simulate_contacts.h"
#include "simulate_obstacles.h"
#include "simulate_run.h"
#include "sinew/common/sampled_signal.h"

namespace sinew {

/// Targets of some effectors over time.
struct TargetSignal {
  SampledSignal positions;     ///< 3 x effectors [m]; what is not given or not controlled is the point at rest
  std::vector<bool> targeted;  ///< per effector
};

/// Columns `t` and target_NAME_x .. z of one or more effectors, each with at least the axes that it controls. Other
/// columns of a run do not matter. Throws ConfigError.
TargetSignal readTargetSignal(const CsvTable& table, const RobotModel& robot);

/// The inverse controller along the targets, one row a cycle, from the equilibrium with no cable pulled; with a
/// recorder the contact problems of every cycle too. Throws ConfigError when there is no such equilibrium.
RunSummary simulateTargets(std::shared_ptr<const RobotModel> robot, const TargetSignal& targets,
                           const ObstacleSignal& obstacles, double rate, RunWriter& writer,
                           ContactRecorder* recorder = nullptr);

}  // namespace sinew
