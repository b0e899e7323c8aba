#pragma once

#include <cstdint>
#include <deque>
#include <random>

#include "sinew/common/types.h"

namespace sinew {

/// What a tracking system sees of the effectors: sampled at its own rate, noisy and late.
class SimulatedTracker {
 public:
  struct Parameters {
    double rate = 60;    ///< Hz
    double latency = 0;  ///< s from the exposure to the arrival of its sample
    double noise = 0;    ///< m, standard deviation per axis
    std::uint32_t seed = 1;
  };
  struct Sample {
    double time = 0;  ///< s, of the exposure
    VecX effectors;   ///< 3 x effectors [m]
  };

  explicit SimulatedTracker(const Parameters& parameters) : parameters_(parameters), random_(parameters.seed) {}

  /// Shows the tracker where the effectors are at `time` [s]. Exposures that fell between this look and the one before
  /// see the effectors on the straight line between the two.
  void look(double time, const VecX& effectors);

  /// Hands out the oldest sample that has arrived by `time` [s]; false when there is none.
  bool take(double time, Sample& sample);

 private:
  void expose(double time, const VecX& effectors);

  Parameters parameters_;
  std::mt19937 random_;
  double next_exposure_ = 0;  // s
  Sample seen_;               // by the last look
  std::deque<Sample> under_way_;
};

}  // namespace sinew
