#include "control_report.h"

#include <algorithm>
#include <string>

#include "real_time.h"

namespace sinew {
namespace {

using diagnostic_msgs::DiagnosticStatus;

/// Counts by reason, the last refusal in words, and a warning when there are more than at the last report.
void reportRefusals(const std::string& what, const RefusalLog& log, std::uint64_t& reported,
                    diagnostic_updater::DiagnosticStatusWrapper& status) {
  const RefusalLog::Counts counts = log.counts();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    status.add(what + " refused: " + nameOf(static_cast<RefusalReason>(i)), counts[i]);
  }
  status.add(what + " last refused", log.last());
  const std::uint64_t total = log.total();
  if (total > reported) status.mergeSummary(DiagnosticStatus::WARN, "refused: " + log.last());
  reported = total;
}

std::uint64_t sum(const std::array<std::uint64_t, 4>& counts) {
  return counts[0] + counts[1] + counts[2] + counts[3];
}

}  // namespace

ControlReport::ControlReport(const ControlMode& mode, const TargetInbox& targets, const ObstacleInbox& obstacles,
                             const ActuatorInbox& actuators, NewestWins<ControlSummary>& summary)
    : mode_(mode),
      targets_(targets),
      obstacles_(obstacles),
      actuators_(actuators),
      summary_(summary),
      time_before_(steadyNow()),
      time_(time_before_) {}

void ControlReport::addTo(diagnostic_updater::Updater& diagnostics) {
  diagnostics.add("control", this, &ControlReport::reportControl);
  diagnostics.add("deadlines", this, &ControlReport::reportDeadlines);
  diagnostics.add("inputs", this, &ControlReport::reportInputs);
  if (!obstacles_.report().empty()) diagnostics.add("obstacles", this, &ControlReport::reportObstacles);
}

void ControlReport::update() {
  before_ = now_;
  time_before_ = time_;
  summary_.update();
  now_ = summary_.front();
  time_ = steadyNow();
}

void ControlReport::reportControl(Status& status) {
  const std::uint64_t held = sum(now_.held) - sum(before_.held);
  const bool disabled = now_.status == ControllerState::DISABLED;
  status.summary(DiagnosticStatus::OK, disabled ? mode_.disabledReason() : "tracking");
  if (now_.status == ControllerState::DEGRADED) status.summary(DiagnosticStatus::WARN, now_.reason);
  if (held > 0) status.mergeSummaryf(DiagnosticStatus::WARN, "%lu cycles held", static_cast<unsigned long>(held));
  if (now_.status == ControllerState::HELD) status.mergeSummary(DiagnosticStatus::ERROR, "held");

  const double elapsed = std::max(time_ - time_before_, 1e-3);
  status.addf("rate [Hz]", "%.2f", static_cast<double>(now_.cycle - before_.cycle) / elapsed);
  status.add("cycles", now_.cycle);
  status.addf("cycle median [ms]", "%.3f", 1e3 * now_.median);
  status.addf("cycle maximum [ms]", "%.3f", 1e3 * now_.maximum);
  status.add("held: not finite", now_.held[static_cast<std::size_t>(HoldReason::kNotFinite)]);
  status.add("held: not positive definite", now_.held[static_cast<std::size_t>(HoldReason::kNotPositiveDefinite)]);
  status.add("held: obstacle lost", now_.held[static_cast<std::size_t>(HoldReason::kNone)]);
  status.add("held: quadratic program", now_.held[static_cast<std::size_t>(HoldReason::kQpFailed)]);
}

void ControlReport::reportDeadlines(Status& status) {
  const std::uint64_t misses = now_.misses - before_.misses;
  const char* const left_out = describe(now_.level);
  status.summary(DiagnosticStatus::OK, "kept");
  if (now_.level != OverloadLevel::kNone) status.summary(DiagnosticStatus::WARN, left_out);
  if (misses > 0) status.mergeSummaryf(DiagnosticStatus::WARN, "%lu missed", static_cast<unsigned long>(misses));
  if (now_.unsent > before_.unsent) status.mergeSummary(DiagnosticStatus::ERROR, "commands not sent");
  status.add("deadline misses", now_.misses);
  status.addf("command p99 [ms]", "%.3f", 1e3 * now_.recent_answer);
  status.addf("command worst [ms]", "%.3f", 1e3 * now_.worst_answer);
  status.add("overload level", static_cast<int>(now_.level));
  for (int level = 0; level < kOverloadLevels; ++level) {
    status.add("cycles at level " + std::to_string(level), now_.levels[static_cast<std::size_t>(level)]);
  }
  status.add("commands not sent", now_.unsent);
}

void ControlReport::reportInputs(Status& status) {
  status.summary(DiagnosticStatus::OK, "no message refused");
  reportRefusals("targets", targets_.refusals(), target_refusals_, status);
  reportRefusals("actuator state", actuators_.refusals(), driver_refusals_, status);
  reportRefusals("obstacles", obstacles_.refusals(), obstacle_refusals_, status);
  status.add("targets accepted", targets_.accepted());
  status.add("obstacles accepted", obstacles_.accepted());
  const DriverReading reading = actuators_.latest();
  status.add("driver", reading.receipt < 0 ? "nothing heard" : nameOfDriverState(reading.driver_state));
  status.addf("driver state age [s]", "%.3f", reading.receipt < 0 ? -1.0 : steadyNow() - reading.receipt);
}

void ControlReport::reportObstacles(Status& status) {
  status.summary(DiagnosticStatus::OK, "every obstacle is where it is thought to be");
  std::uint64_t outliers = 0;
  for (const ObstacleInbox::Report& report : obstacles_.report()) {
    const char* const state = !report.heard     ? "not heard of, taken to be where the robot's description says"
                              : report.lost     ? "lost"
                              : !report.present ? "absent"
                                                : "present";
    if (!report.heard) status.mergeSummary(DiagnosticStatus::WARN, "obstacle '" + report.name + "' is not heard of");
    if (report.lost) status.mergeSummary(DiagnosticStatus::ERROR, "obstacle '" + report.name + "' is lost");
    status.add(report.name, state);
    status.addf(report.name + " age [s]", "%.3f", report.age);
    status.add(report.name + " outliers", report.outliers);
    outliers += report.outliers;
  }
  if (outliers > outliers_) status.mergeSummary(DiagnosticStatus::WARN, obstacles_.lastOutlier());
  outliers_ = outliers;
}

}  // namespace sinew
