#include "sinew/inverse/step_damping.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr double kTolerated = 0.5;   // surprise over step and push
constexpr double kShortStep = 1e-7;  // m below which a step says nothing
constexpr double kFirst = 0.05, kLargest = 10, kSmallest = 1e-3;
constexpr double kRise = 2, kFall = 0.7;

}  // namespace

void StepDamping::update(double surprise, double pushed) {
  if (last_motion_ > kShortStep && (overshoots_ || surprise > kTolerated * (last_motion_ + pushed))) {
    value_ = std::min(kLargest, std::max(kRise * value_, kFirst));
  } else {
    value_ = value_ < kSmallest ? 0 : kFall * value_;
  }
}

}  // namespace sinew
