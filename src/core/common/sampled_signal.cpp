#include "sinew/common/sampled_signal.h"

#include <algorithm>
#include <stdexcept>

namespace sinew {

SampledSignal::SampledSignal(const VecX& times, const MatX& values) : times_(times), values_(values) {
  if (times.size() == 0 || times.size() != values.cols()) {
    throw std::invalid_argument("SampledSignal: one column of values for each time, at least one");
  }
  for (Eigen::Index k = 1; k < times.size(); ++k) {
    if (!(times[k] > times[k - 1])) throw std::invalid_argument("SampledSignal: times must rise");
  }
}

void SampledSignal::calcValue(double time, VecX& value) const {
  const double* begin = times_.data();
  const double* end = begin + times_.size();
  const Eigen::Index after = std::upper_bound(begin, end, time) - begin;
  if (after == 0 || after == times_.size()) {
    value = values_.col(after == 0 ? 0 : after - 1);
    return;
  }
  const double fraction = (time - times_[after - 1]) / (times_[after] - times_[after - 1]);
  value = (1 - fraction) * values_.col(after - 1) + fraction * values_.col(after);
}

}  // namespace sinew
