#include "sinew/hardware/cable_transmission.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/hardware/servo_registers.h"

namespace sinew {
namespace {

TEST(CableTransmission, OneTurnIsOneCircumference) {
  CableTransmission cable(0.01, 1, 1.78);
  cable.setZero(500);
  EXPECT_DOUBLE_EQ(cable.displacement(500), 0);
  EXPECT_NEAR(cable.displacement(500 + 4096), 2 * 3.14159265358979 * 0.01, 1e-12);
  CableTransmission other(0.01, -1, 1.78);
  EXPECT_NEAR(other.displacement(-4096), 2 * 3.14159265358979 * 0.01, 1e-12);
}

TEST(CableTransmission, CountsAndBack) {
  for (const int sign : {1, -1}) {
    CableTransmission cable(0.0137, sign, 1.78);
    cable.setZero(-12345, 0.02);
    EXPECT_NEAR(cable.displacement(-12345), 0.02, 1e-15);
    for (int c = -300000; c < 300000; c += 977) EXPECT_EQ(cable.counts(cable.displacement(c)), c);
  }
}

TEST(CableTransmission, GoalCurrentNeverExceedsTheTension) {
  CableTransmission cable(0.01, 1, 1.78);
  for (double tension = 0.5; tension < 200; tension += 0.37) {
    const std::int32_t units = cable.goalCurrent(tension);
    EXPECT_LE(cable.tension(units), tension);
    EXPECT_GT(cable.tension(units + 1), tension);
  }
}

TEST(CableTransmission, TensionIsPositiveWhileReelingIn) {
  // 100 units are 0.269 A, 0.269 A * 1.78 N m/A = 0.47882 N m, over 0.01 m: 47.882 N.
  EXPECT_NEAR(CableTransmission(0.01, 1, 1.78).tension(100), 47.882, 1e-9);
  EXPECT_NEAR(CableTransmission(0.01, -1, 1.78).tension(-100), 47.882, 1e-9);
  EXPECT_NEAR(CableTransmission(0.01, -1, 1.78).amperes(-100), 0.269, 1e-12);
}

TEST(CableTransmission, ProfileIsNotSlowerThanAsked) {
  const CableTransmission cable(0.01, 1, 1.78);
  EXPECT_GE(cable.profileVelocity(0.04) * kRadiansPerSecondPerUnit * 0.01, 0.04);
  EXPECT_LT((cable.profileVelocity(0.04) - 1) * kRadiansPerSecondPerUnit * 0.01, 0.04);
}

}  // namespace
}  // namespace sinew
