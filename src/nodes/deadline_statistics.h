#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sinew/inverse/cycle.h"

namespace sinew {

/// How well commands keep their deadline, the end of their cycle's period. Sized at set-up.
class DeadlineStatistics {
 public:
  DeadlineStatistics(double period, int window);

  /// A cycle at `level` whose command came `answered` [s] after it was due to begin; periods left out since the start.
  void add(double answered, std::uint64_t skipped, OverloadLevel level);
  /// Sorts out what is of the last `window` cycles.
  void update();

  /// Commands that came after their period, and periods left out.
  std::uint64_t misses() const { return late_ + skipped_; }
  double worst() const { return worst_; }    ///< s, of all cycles, from when they were due to their command
  double recent() const { return recent_; }  ///< s, that 99 % of the window lie below or at
  const std::array<std::uint64_t, kOverloadLevels>& levels() const { return levels_; }  ///< cycles at each level

 private:
  double period_;                // s
  std::vector<double> samples_;  // s, by cycle modulo window
  std::vector<double> scratch_;
  std::size_t count_ = 0;
  std::uint64_t late_ = 0, skipped_ = 0;
  double worst_ = 0, recent_ = 0;
  std::array<std::uint64_t, kOverloadLevels> levels_{};
};

}  // namespace sinew
