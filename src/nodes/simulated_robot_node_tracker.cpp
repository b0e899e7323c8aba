#include "simulated_robot_node_tracker.h"

#include <utility>

namespace sinew {

void SimulatedTracker::look(double time, const VecX& effectors) {
  if (seen_.effectors.size() == 0) {
    next_exposure_ = time;
    seen_ = {time, effectors};
  }
  for (; next_exposure_ <= time; next_exposure_ += 1 / parameters_.rate) {
    const double part = time > seen_.time ? (next_exposure_ - seen_.time) / (time - seen_.time) : 1;
    expose(next_exposure_, seen_.effectors + part * (effectors - seen_.effectors));
  }
  seen_ = {time, effectors};
}

void SimulatedTracker::expose(double time, const VecX& effectors) {
  under_way_.push_back({time, effectors});
  if (parameters_.noise <= 0) return;
  std::normal_distribution<double> noise(0, parameters_.noise);
  VecX& seen = under_way_.back().effectors;
  for (int i = 0; i < seen.size(); ++i) seen[i] += noise(random_);
}

bool SimulatedTracker::take(double time, Sample& sample) {
  if (under_way_.empty() || under_way_.front().time + parameters_.latency > time) return false;
  sample = std::move(under_way_.front());
  under_way_.pop_front();
  return true;
}

}  // namespace sinew
