#include "sinew/hardware/actuator_watch.h"

#include <cmath>

namespace sinew {
namespace {

// Whether `passed` has held for longer than `limit` [s], counted in `time`.
bool lasts(bool passed, double dt, double limit, double& time) {
  time = passed ? time + dt : 0;
  return passed && time > limit;
}

}  // namespace

ActuatorWatch::ActuatorWatch(const std::vector<ActuatorDescription>& actuators) {
  for (const ActuatorDescription& a : actuators) states_.push_back({a.watch});
}

void ActuatorWatch::reset() {
  for (State& s : states_) s = {s.limits};
}

bool ActuatorWatch::update(const std::vector<ActuatorReading>& readings, const std::vector<double>& applied,
                           const double* expected, double dt) {
  bool well = true;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    State& s = states_[i];
    const ActuatorReading& r = readings[i];
    if (!r.valid) continue;
    const WatchDescription& w = s.limits;
    const bool off = std::abs(r.measured - applied[i]) > w.difference_max;
    const bool slack = std::isfinite(expected[i]) && expected[i] - r.effort > w.effort_missing;
    const bool over = std::abs(r.current) > w.current_max;
    if (lasts(off, dt, w.time, s.off_time) || lasts(slack, dt, w.time, s.slack_time)) s.fault |= kFaultDifference;
    if (lasts(over, dt, w.time, s.over_time)) s.fault |= kFaultCurrent;
    if (r.temperature > w.temperature_max) s.fault |= kFaultHot;
    if (r.measured > w.pressure_max) s.fault |= kFaultPressure;
    well = well && s.fault == 0;
  }
  return well;
}

}  // namespace sinew
