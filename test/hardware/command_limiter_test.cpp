#include "sinew/hardware/command_limiter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace sinew {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(CommandLimiter, WhateverArrivesStaysFiniteInRangeAndWithinTheRate) {
  std::mt19937 random(1);
  CommandLimiter limiter({{-0.03, 0.06, 0.15}, {0, 0.01, 0.02}}, 0.02);
  limiter.reset({0.01, 0.005});
  std::vector<double> last = limiter.applied();
  const double rates[] = {0.15, 0.02}, lows[] = {-0.03, 0}, highs[] = {0.06, 0.01};
  for (int n = 0; n < 20000; ++n) {
    std::vector<double> wanted(2);
    for (double& w : wanted) {
      const unsigned kind = random() % 8;
      w = kind == 0   ? kNan
          : kind == 1 ? kInfinity
          : kind == 2 ? -kInfinity
          : kind == 3 ? 1e300
                      : std::uniform_real_distribution<double>(-0.1, 0.1)(random);
    }
    const double interval = 0.001 * static_cast<double>(random() % 60);
    limiter.update(wanted, interval);
    for (std::size_t i = 0; i < 2; ++i) {
      const double x = limiter.applied()[i];
      ASSERT_TRUE(std::isfinite(x));
      ASSERT_GE(x, lows[i]);
      ASSERT_LE(x, highs[i]);
      ASSERT_LE(std::abs(x - last[i]), rates[i] * std::min(interval, 0.02) + 1e-15);
    }
    last = limiter.applied();
  }
}

TEST(CommandLimiter, ReachesAnAllowedTargetExactlyAndSaysWhenItDidNot) {
  CommandLimiter limiter({{0, 1, 1}}, 1);
  limiter.reset({0});
  EXPECT_TRUE(limiter.update({0.25}, 0.1));
  EXPECT_DOUBLE_EQ(limiter.applied()[0], 0.1);
  EXPECT_TRUE(limiter.update({0.25}, 0.1));
  EXPECT_FALSE(limiter.update({0.25}, 0.1));
  EXPECT_EQ(limiter.applied()[0], 0.25);
}

TEST(CommandLimiter, ComesBackIntoTheRangeAtTheRate) {
  CommandLimiter limiter({{0, 1, 1}}, 1);
  limiter.reset({1.5});
  limiter.update({2}, 0.1);
  EXPECT_DOUBLE_EQ(limiter.applied()[0], 1.4);
}

TEST(CommandLimiter, NotFiniteKeepsTheSetPoint) {
  CommandLimiter limiter({{0, 1, 1}}, 1);
  limiter.reset({0.5});
  EXPECT_TRUE(limiter.update({kNan}, 0.1));
  EXPECT_EQ(limiter.applied()[0], 0.5);
}

TEST(CommandLimiter, TimeThatRunsBackwardsMovesNothing) {
  CommandLimiter limiter({{0, 1, 1}}, 1);
  limiter.reset({0.5});
  limiter.update({1}, -3);
  EXPECT_EQ(limiter.applied()[0], 0.5);
}

}  // namespace
}  // namespace sinew
