#include "stage_statistics.h"

#include <algorithm>

namespace sinew {

StageStatistics::StageStatistics(int stages, int window)
    : stages_(index(stages)),
      window_(static_cast<std::size_t>(std::max(window, 1))),
      samples_(stages_, std::vector<double>(window_, 0.0)),
      scratch_(window_, 0.0),
      last_(stages_, 0.0),
      median_(stages_, 0.0),
      maximum_(stages_, 0.0) {}

void StageStatistics::add(const double* durations) {
  for (std::size_t stage = 0; stage < stages_; ++stage) {
    last_[stage] = durations[stage];
    samples_[stage][count_ % window_] = durations[stage];
  }
  ++count_;
}

void StageStatistics::update() {
  const auto filled = static_cast<std::ptrdiff_t>(std::min(count_, window_));
  if (filled == 0) return;
  for (std::size_t stage = 0; stage < stages_; ++stage) {
    std::copy_n(samples_[stage].begin(), filled, scratch_.begin());
    const auto middle = scratch_.begin() + filled / 2;
    std::nth_element(scratch_.begin(), middle, scratch_.begin() + filled);
    median_[stage] = *middle;
    maximum_[stage] = *std::max_element(middle, scratch_.begin() + filled);
  }
}

}  // namespace sinew
