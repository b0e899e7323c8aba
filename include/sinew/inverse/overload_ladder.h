#pragma once

#include <array>

#include "sinew/inverse/cycle.h"

namespace sinew {

/// What a cycle has cost, on any clock.
struct CycleCost {
  double taken = 0;   ///< s, of the cycle's own thread
  double spared = 0;  ///< s, that one level less would have added, as far as anybody knows
};

/// Decides how much the next cycle leaves out, from what the last ones took: up a level where two in a row leave too
/// little of their period, to the top where both outlast it, and down a level where every cycle for a while would have
/// fitted with ease at the level below. A level that had to be taken back soon is waited for twice as long the next
/// time, so that a load between two levels does not make it flap. Deterministic, without a clock of its own.
class OverloadLadder {
 public:
  struct Settings {
    double above = 0.9;     ///< 1, share of the period; cycles that take more go up
    double below = 0.75;    ///< 1, share of the period; cycles that would take less go down
    double recovery = 0.5;  ///< s, for which they have to
    /// By level: whether it leaves anything out with the robot at hand; others are passed over. Ends are always used.
    std::array<bool, kOverloadLevels> useful = {{true, true, true, true}};
  };

  /// At first it stands at the top: nobody knows yet what a cycle costs.
  explicit OverloadLadder(const Settings& settings) : settings_(settings) {}

  /// The level of the next cycle, after one at the present level in a period of `period` [s].
  OverloadLevel update(const CycleCost& cost, double period);
  OverloadLevel level() const { return level_; }

 private:
  OverloadLevel next(int direction) const;
  void climb(OverloadLevel level);
  void descend();
  double patience() const { return settings_.recovery * doublings_; }

  Settings settings_;
  OverloadLevel level_ = OverloadLevel::kSharedLinearisation;
  int tight_ = 0;                 // cycles in a row
  bool outlasted_ = false;        // all of them, their period
  double easy_ = 0;               // s, for which every cycle would have fitted below
  double since_descent_ = 1e300;  // s
  double doublings_ = 1;          // power of two
};

}  // namespace sinew
