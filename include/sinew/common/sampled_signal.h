#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// Values given at rising times: linear between two samples, constant before the first and after the last.
class SampledSignal {
 public:
  /// `times` [s] rise, one or more; column k of `values` belongs to times[k]. Throws std::invalid_argument otherwise.
  SampledSignal(const VecX& times, const MatX& values);

  int samples() const { return static_cast<int>(times_.size()); }
  int size() const { return static_cast<int>(values_.rows()); }
  const VecX& times() const { return times_; }    ///< s
  const MatX& values() const { return values_; }  ///< size x samples

  /// Resizes `value` to `size()`.
  void calcValue(double time, VecX& value) const;

 private:
  VecX times_;
  MatX values_;
};

}  // namespace sinew
