#pragma once

#include <vector>

namespace sinew {

/// Newest, median and largest duration of the stages of a cycle over the last `window` cycles. Sized at set-up.
class StageStatistics {
 public:
  StageStatistics(int stages, int window);

  /// One duration [s] per stage.
  void add(const double* durations);

  /// Sorts out medians and maxima; costs `stages` partial sorts of the window.
  void update();

  double last(int stage) const { return last_[index(stage)]; }        ///< s
  double median(int stage) const { return median_[index(stage)]; }    ///< s, at the last update
  double maximum(int stage) const { return maximum_[index(stage)]; }  ///< s, at the last update

 private:
  static std::size_t index(int stage) { return static_cast<std::size_t>(stage); }

  std::size_t stages_;
  std::size_t window_;
  std::size_t count_ = 0;                     // cycles added
  std::vector<std::vector<double>> samples_;  // stage, cycle modulo window [s]
  std::vector<double> scratch_, last_, median_, maximum_;
};

}  // namespace sinew
