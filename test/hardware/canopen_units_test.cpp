#include "sinew/hardware/canopen_units.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace sinew {
namespace {

constexpr double kPi = 3.14159265358979323846;

CanopenSettings makeSettings(CanopenEffort effort = CanopenEffort::kTorque, double rated_unit = 1e-3) {
  CanopenSettings s;
  s.counts_per_turn = 2000;
  s.gear = 4;
  s.effort = effort;
  s.rated_unit = rated_unit;
  return s;
}

WinchDescription makeCable(int sign = 1) {
  WinchDescription cable;
  cable.spool_radius = 0.02;
  cable.sign = sign;
  cable.torque_constant = 0.4;
  return cable;
}

// One turn of the spool is four of the motor, 8000 counts, and 2 pi 0.02 m of cable.
TEST(CanopenUnits, ATurnOfTheSpool) {
  CanopenUnits units(makeSettings(), makeCable());
  EXPECT_NEAR(units.displacement(8000), 2 * kPi * 0.02, 1e-15);
  EXPECT_EQ(units.counts(2 * kPi * 0.02), 8000);
  units.setZero(1000, 0.05);
  EXPECT_NEAR(units.displacement(1000), 0.05, 1e-15);
  EXPECT_NEAR(units.displacement(9000), 0.05 + 2 * kPi * 0.02, 1e-12);
  CanopenUnits reversed(makeSettings(), makeCable(-1));
  EXPECT_NEAR(reversed.displacement(8000), -2 * kPi * 0.02, 1e-15);
}

TEST(CanopenUnits, CountsComeBack) {
  std::mt19937 random(11);
  std::uniform_int_distribution<std::int32_t> any(std::numeric_limits<std::int32_t>::min() + 1);
  for (const int sign : {1, -1}) {
    CanopenUnits units(makeSettings(), makeCable(sign));
    for (int i = 0; i < 1000; ++i) {
      const std::int32_t counts = any(random);
      EXPECT_EQ(units.counts(units.displacement(counts)), counts);
    }
  }
}

TEST(CanopenUnits, StaysWithin32Bits) {
  const CanopenUnits units(makeSettings(), makeCable());
  EXPECT_TRUE(units.canTell(1));
  EXPECT_FALSE(units.canTell(1e6));
  EXPECT_FALSE(units.canTell(-1e6));
  EXPECT_EQ(units.counts(1e6), std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(units.counts(-1e6), -std::numeric_limits<std::int32_t>::max());
}

// 0.25 N m rated: 100 per mille are 0.025 N m of the motor, 0.1 N m of the spool, 5 N of cable, 0.25 A.
TEST(CanopenUnits, EffortByRatedTorque) {
  CanopenUnits units(makeSettings(), makeCable());
  EXPECT_TRUE(units.needsRating());
  units.setRating(250);
  EXPECT_NEAR(units.tension(100), 5, 1e-12);
  EXPECT_NEAR(units.amperes(100), 0.25, 1e-12);
  EXPECT_EQ(units.effortLimit(5), 100);
  EXPECT_EQ(units.effortLimit(4.99), 99);
  CanopenUnits micro(makeSettings(CanopenEffort::kTorque, 1e-6), makeCable());  // EPOS4 tells micro N m
  micro.setRating(250000);
  EXPECT_NEAR(micro.tension(100), 5, 1e-12);
}

// 2.5 A rated: 100 per mille are 0.25 A, 0.1 N m of the spool.
TEST(CanopenUnits, EffortByRatedCurrent) {
  CanopenUnits units(makeSettings(CanopenEffort::kCurrent), makeCable(-1));
  units.setRating(2500);
  EXPECT_NEAR(units.tension(-100), 5, 1e-12);
  EXPECT_NEAR(units.amperes(-100), 0.25, 1e-12);
}

TEST(CanopenUnits, EffortByMilliamperes) {
  const CanopenUnits units(makeSettings(CanopenEffort::kEpos4Current), makeCable());
  EXPECT_FALSE(units.needsRating());
  EXPECT_NEAR(units.tension(250), 5, 1e-12);
  EXPECT_EQ(units.effortLimit(5), 250);
}

TEST(CanopenUnits, ALimitNeverExceedsItsTension) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> any(0, 100);
  CanopenUnits units(makeSettings(), makeCable());
  units.setRating(250);
  for (int i = 0; i < 1000; ++i) {
    const double tension = any(random);
    const double limit = units.effortLimit(tension);
    EXPECT_LE(units.tension(static_cast<std::int32_t>(limit)), tension * (1 + 1e-9));
    EXPECT_GT(units.tension(static_cast<std::int32_t>(limit) + 1), tension);
  }
}

// 1 rad/s of the spool: 4 rad/s of the motor, 38.2 rpm; 8000 counts in 2 pi seconds.
TEST(CanopenUnits, SpeedsAreNeverBelow) {
  CanopenSettings s = makeSettings();
  EXPECT_EQ(CanopenUnits(s, makeCable()).speed(1), 39u);
  s.speed = CanopenSpeed::kCounts;
  EXPECT_EQ(CanopenUnits(s, makeCable()).speed(1), 1274u);
  EXPECT_EQ(CanopenUnits(s, makeCable()).rpm(1), 39u);
  EXPECT_EQ(CanopenUnits(s, makeCable()).speed(1e-9), 1u);
  EXPECT_EQ(CanopenUnits(s, makeCable()).speed(1e12), 0xFFFFFFFFu);
}

TEST(CanopenUnits, Windows) {
  const CanopenUnits units(makeSettings(), makeCable());
  EXPECT_EQ(units.window(2 * kPi * 0.02), 8000u);
  EXPECT_EQ(units.window(std::numeric_limits<double>::infinity()), 0xFFFFFFFFu);
}

}  // namespace
}  // namespace sinew
