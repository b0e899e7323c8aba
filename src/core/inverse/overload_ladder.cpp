#include "sinew/inverse/overload_ladder.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr int kTightCycles = 2;      // in a row; one alone is the machine's doing
constexpr double kMostPatient = 64;  // times the recovery time

}  // namespace

/// The nearest useful level up (1) or down (-1).
OverloadLevel OverloadLadder::next(int direction) const {
  const int last = direction > 0 ? kOverloadLevels - 1 : 0;
  int level = static_cast<int>(level_);
  while (level != last) {
    level += direction;
    if (settings_.useful[static_cast<std::size_t>(level)]) break;
  }
  return static_cast<OverloadLevel>(level);
}

OverloadLevel OverloadLadder::update(const CycleCost& cost, double period) {
  since_descent_ += period;
  if (since_descent_ > 2 * patience()) doublings_ = 1;
  const bool tight = cost.taken > settings_.above * period;
  outlasted_ = tight && (outlasted_ || tight_ == 0) && cost.taken > period;
  tight_ = tight ? tight_ + 1 : 0;
  easy_ = cost.taken + cost.spared < settings_.below * period ? easy_ + period : 0;
  if (tight_ >= kTightCycles) {
    climb(outlasted_ ? kHighestOverload : next(1));
  } else if (easy_ > patience()) {
    descend();
  }
  return level_;
}

void OverloadLadder::climb(OverloadLevel level) {
  tight_ = 0;
  if (level_ == kHighestOverload) return;
  if (since_descent_ < 2 * patience()) doublings_ = std::min(kMostPatient, 2 * doublings_);
  level_ = level;
}

void OverloadLadder::descend() {
  easy_ = 0;
  if (level_ == OverloadLevel::kNone) return;
  since_descent_ = 0;
  level_ = next(-1);
}

}  // namespace sinew
