#include "sinew/hardware/simulated_chamber.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew {
namespace {

SimulatedChamber::Parameters makeParameters() {
  SimulatedChamber::Parameters p;
  p.volume = 1e-4;
  p.conductance = 5e-4;
  return p;
}

TEST(SimulatedChamber, FillsExponentiallyWhateverTheStep) {
  for (const double dt : {0.1, 0.01, 0.001}) {
    SimulatedChamber c(makeParameters());
    for (double t = 0; t < 0.3 - dt / 2; t += dt) c.step(dt, 0.5, 1e5);
    EXPECT_NEAR(c.pressure(), 1e5 * (1 - std::exp(-0.3 * 0.5 * 5)), 1e-3) << dt;
  }
}

TEST(SimulatedChamber, NeverPassesItsSource) {
  SimulatedChamber c(makeParameters());
  c.step(1e6, 1, 1e5);
  EXPECT_LE(c.pressure(), 1e5);
  c.step(1e6, 1, -5e4);
  EXPECT_GE(c.pressure(), -5e4);
}

TEST(SimulatedChamber, LeaksAtItsRateAndHoldsWithout) {
  SimulatedChamber c(makeParameters());
  c.step(100, 1, 1e5);
  c.step(10, 0, 0);
  EXPECT_NEAR(c.pressure(), 1e5, 1e-3);
  c.setLeak(2);
  c.step(0.5, 0, 0);
  EXPECT_NEAR(c.pressure(), 1e5 * std::exp(-1), 1e-3);
}

TEST(SimulatedChamber, TakesFromTheSourceWhatItGains) {
  SimulatedChamber c(makeParameters());
  double taken = 0;
  for (int n = 0; n < 50; ++n) taken += c.step(0.01, 1, 1e5);
  EXPECT_NEAR(taken, c.pressure() * c.volume(), 1e-9 * taken);
}

TEST(SimulatedChamber, PressedTogetherItFollowsBoyle) {
  SimulatedChamber c(makeParameters());
  c.step(100, 1, 1e5);
  c.setVolume(0.5e-4);
  EXPECT_NEAR(c.pressure(), 2 * (1e5 + 101325) - 101325, 1);
}

}  // namespace
}  // namespace sinew
