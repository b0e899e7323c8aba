#include "sinew/hardware/cable_homing.h"

namespace sinew {

CableHoming::CableHoming(const std::vector<ActuatorDescription>& actuators) : set_points_(actuators.size(), 0.0) {
  for (const ActuatorDescription& a : actuators) cables_.push_back({a.cable.homing});
}

void CableHoming::start(const std::vector<ActuatorReading>& readings, const std::vector<bool>& keep) {
  failed_ = -1;
  for (std::size_t i = 0; i < cables_.size(); ++i) {
    Cable& c = cables_[i];
    c.start = set_points_[i] = readings[i].measured;
    c.taut = 0;
    c.done = keep[i] || c.homing.method != HomingMethod::kTension;
  }
}

CableHoming::Progress CableHoming::update(const std::vector<ActuatorReading>& readings, double dt) {
  bool all_done = true;
  for (std::size_t i = 0; i < cables_.size(); ++i) {
    Cable& c = cables_[i];
    if (c.done) continue;
    if (readings[i].valid) c.taut = readings[i].effort >= c.homing.tension ? c.taut + 1 : 0;
    c.done = c.taut >= kTautReadings;
    all_done = all_done && c.done;
    if (c.done) {
      set_points_[i] = readings[i].measured;
      continue;
    }
    if (c.taut == 0) set_points_[i] += c.homing.speed * dt;
    if (set_points_[i] - c.start <= c.homing.travel) continue;
    failed_ = static_cast<int>(i);
    return Progress::kFailed;
  }
  return all_done ? Progress::kDone : Progress::kBusy;
}

}  // namespace sinew
