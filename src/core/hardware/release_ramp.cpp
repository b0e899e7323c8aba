#include "sinew/hardware/release_ramp.h"

#include <algorithm>

namespace sinew {

void ReleaseRamp::start(const std::vector<bool>& which) {
  which_ = which;
  started_ = false;
  active_ = std::any_of(which_.begin(), which_.end(), [](bool chosen) { return chosen; });
}

double ReleaseRamp::share(Time now) {
  if (!started_) begin_ = now;
  const bool first = !started_;
  started_ = true;
  if (first) return 1;
  return time_ > 0 ? std::max(0., 1 - seconds(now - begin_) / time_) : 0;
}

}  // namespace sinew
