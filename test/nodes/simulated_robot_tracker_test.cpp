#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "simulated_robot_node_tracker.h"

namespace sinew {
namespace {

/// A point that moves evenly: one metre a second along x.
VecX positionAt(double time) {
  return Vec3(time, 0, -0.2);
}

/// Looks every `period` [s] for `duration` [s] and returns what arrives by its end.
std::vector<SimulatedTracker::Sample> watch(const SimulatedTracker::Parameters& parameters, double period,
                                            double duration) {
  SimulatedTracker tracker(parameters);
  std::vector<SimulatedTracker::Sample> samples;
  SimulatedTracker::Sample sample;
  const int looks = static_cast<int>(std::lround(duration / period));
  for (int look = 0; look <= looks; ++look) {
    const double time = period * look;
    tracker.look(time, positionAt(time));
    while (tracker.take(time, sample)) {
      EXPECT_LE(sample.time + parameters.latency, time);
      samples.push_back(sample);
    }
  }
  return samples;
}

TEST(SimulatedTracker, KeepsItsOwnRateAndSeesBetweenTheLooks) {
  SimulatedTracker::Parameters parameters;
  parameters.rate = 60;
  const auto samples = watch(parameters, 0.02, 2);
  ASSERT_NEAR(121, static_cast<double>(samples.size()), 1);
  for (size_t i = 0; i < samples.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(i) / 60, samples[i].time, 1e-9);
    EXPECT_LT((samples[i].effectors - positionAt(samples[i].time)).norm(), 1e-9);
  }
}

TEST(SimulatedTracker, SamplesArriveLate) {
  SimulatedTracker::Parameters parameters;
  parameters.latency = 0.5;
  const auto samples = watch(parameters, 0.02, 2);
  ASSERT_FALSE(samples.empty());
  EXPECT_NEAR(1.5, samples.back().time, 0.04);
}

TEST(SimulatedTracker, NoiseHasItsDeviationAndIsRepeatable) {
  SimulatedTracker::Parameters parameters;
  parameters.noise = 0.001;
  parameters.seed = 7;
  const auto samples = watch(parameters, 0.02, 60);
  double sum = 0, sum_of_squares = 0;
  for (const auto& sample : samples) {
    const VecX error = sample.effectors - positionAt(sample.time);
    sum += error.sum();
    sum_of_squares += error.squaredNorm();
  }
  const double count = 3.0 * static_cast<double>(samples.size());
  EXPECT_NEAR(0, sum / count, 5 * 0.001 / std::sqrt(count));
  EXPECT_NEAR(0.001, std::sqrt(sum_of_squares / count), 5 * 0.001 / std::sqrt(2 * count));

  const auto again = watch(parameters, 0.02, 60);
  parameters.seed = 8;
  const auto other = watch(parameters, 0.02, 60);
  EXPECT_EQ(samples.back().effectors, again.back().effectors);
  EXPECT_NE(samples.back().effectors, other.back().effectors);
}

}  // namespace
}  // namespace sinew
