#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include "actuator_inbox.h"
#include "control_mode.h"
#include "control_summary.h"
#include "obstacle_inbox.h"
#include "sinew/common/newest_wins.h"
#include "target_inbox.h"

namespace sinew {

/// The diagnostics of the inverse model: control, deadlines, inputs and, where there are any, obstacles. Service
/// thread.
class ControlReport {
 public:
  ControlReport(const ControlMode& mode, const TargetInbox& targets, const ObstacleInbox& obstacles,
                const ActuatorInbox& actuators, NewestWins<ControlSummary>& summary);

  void addTo(diagnostic_updater::Updater& diagnostics);
  /// Takes the newest summary for the reports that follow.
  void update();

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;
  void reportControl(Status& status);
  void reportDeadlines(Status& status);
  void reportInputs(Status& status);
  void reportObstacles(Status& status);

  const ControlMode& mode_;
  const TargetInbox& targets_;
  const ObstacleInbox& obstacles_;
  const ActuatorInbox& actuators_;
  NewestWins<ControlSummary>& summary_;
  ControlSummary before_;  // as of the last report
  ControlSummary now_;
  double time_before_, time_;  // s, steady
  std::uint64_t target_refusals_ = 0, driver_refusals_ = 0, obstacle_refusals_ = 0, outliers_ = 0;
};

}  // namespace sinew
