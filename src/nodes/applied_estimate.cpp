#include "applied_estimate.h"

#include <algorithm>
#include <cmath>

namespace sinew {

AppliedEstimate::AppliedEstimate(int actuators)
    : report_(VecX::Zero(actuators)), speed_(VecX::Zero(actuators)), estimate_(VecX::Zero(actuators)) {
  commands_.fill(VecX::Zero(actuators));
}

void AppliedEstimate::reset(const VecX& applied) {
  sent_ = 0;
  reported_ = false;
  speed_.setZero();
  report_ = applied;
  estimate_ = applied;
}

void AppliedEstimate::addCommand(std::uint32_t sequence, const VecX& displacement) {
  if (sent_ == 0) report_sequence_ = sequence - 1;  // where the actuators were before counts as a report
  commands_[sequence % kHistory] = displacement;
  newest_ = sequence;
  ++sent_;
  updateEstimate();
}

void AppliedEstimate::addReport(std::uint32_t sequence, const VecX& applied) {
  if (!knows(sequence)) return;
  const std::uint32_t advance = sequence - report_sequence_;
  if (advance >= kHistory) {
    speed_.setZero();
  } else if (advance > 0) {
    speed_ = (applied - report_).cwiseAbs() / advance;
  } else {
    speed_ = speed_.cwiseMax((applied - report_).cwiseAbs());
  }
  report_ = applied;
  report_sequence_ = sequence;
  reported_ = true;
  updateEstimate();
}

bool AppliedEstimate::knows(std::uint32_t sequence) const {
  return sent_ > 0 && newest_ - sequence < std::min(sent_, kHistory);
}

void AppliedEstimate::updateEstimate() {
  estimate_ = command(newest_);
  if (!reported_ || !knows(report_sequence_)) return;
  const VecX& asked = command(report_sequence_);
  for (int i = 0; i < estimate_.size(); ++i) {
    const double withheld = asked[i] - report_[i];
    if (std::abs(withheld) <= kSame) continue;
    double position = report_[i];
    for (std::uint32_t sequence = report_sequence_ + 1; newest_ - sequence < kHistory; ++sequence) {
      const double move = command(sequence)[i] - position;
      const bool same_way = move * withheld > 0;
      position += same_way ? std::copysign(std::min(std::abs(move), speed_[i]), move) : move;
    }
    estimate_[i] = position;
  }
}

}  // namespace sinew
