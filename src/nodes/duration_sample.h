#pragma once

#include <cstddef>
#include <vector>

namespace sinew {

/// Durations of something that is done over and over.
class DurationSample {
 public:
  void add(double seconds) { seconds_.push_back(seconds); }
  std::size_t size() const { return seconds_.size(); }

  double calcMean() const;                  ///< s; NaN without any
  double calcQuantile(double share) const;  ///< s, the value that `share` in (0, 1] of all lie below or at; likewise

 private:
  std::vector<double> seconds_;
};

}  // namespace sinew
