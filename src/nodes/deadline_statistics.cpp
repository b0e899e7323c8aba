#include "deadline_statistics.h"

#include <algorithm>
#include <cmath>

namespace sinew {

DeadlineStatistics::DeadlineStatistics(double period, int window)
    : period_(period), samples_(static_cast<std::size_t>(std::max(window, 1)), 0.0), scratch_(samples_) {}

void DeadlineStatistics::add(double answered, std::uint64_t skipped, OverloadLevel level) {
  samples_[count_++ % samples_.size()] = answered;
  if (answered > period_) ++late_;
  skipped_ = skipped;
  worst_ = std::max(worst_, answered);
  ++levels_[static_cast<std::size_t>(level)];
}

void DeadlineStatistics::update() {
  const std::size_t filled = std::min(count_, samples_.size());
  if (filled == 0) return;
  const auto end = std::copy_n(samples_.begin(), filled, scratch_.begin());
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(0.99 * static_cast<double>(filled))) - 1;
  std::nth_element(scratch_.begin(), scratch_.begin() + rank, end);
  recent_ = scratch_[static_cast<std::size_t>(rank)];
}

}  // namespace sinew
