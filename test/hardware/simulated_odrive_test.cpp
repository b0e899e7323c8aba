#include "sinew/hardware/simulated_odrive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "hardware/can_frames.h"

namespace sinew {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr int kNode = 3;

float floatAt(const CanFrame& f, std::size_t at) {
  float value = 0;
  std::memcpy(&value, &f.data[at], sizeof value);
  return value;
}

CanFrame makeFloats(int command, double a, double b) {
  CanFrame f = makeFrame(static_cast<std::uint32_t>(kNode * 32 + command), {0, 0, 0, 0, 0, 0, 0, 0});
  const float values[] = {static_cast<float>(a), static_cast<float>(b)};
  std::memcpy(f.data.data(), values, sizeof values);
  return f;
}

struct Bench {
  explicit Bench(const SimulatedOdrive::Parameters& parameters = {}) : drive(kNode, parameters) {}
  std::vector<CanFrame> tell(const CanFrame& frame) {
    std::vector<CanFrame> out;
    drive.take(frame, now, out);
    return out;
  }
  CanFrame ask(int command) {
    const std::vector<CanFrame> out = tell(makeRemote(static_cast<std::uint32_t>(kNode * 32 + command), 0));
    EXPECT_EQ(out.size(), 1u) << command;
    return out.empty() ? CanFrame() : out[0];
  }
  std::vector<CanFrame> pass(double time) {
    std::vector<CanFrame> out;
    for (int n = 0; n < static_cast<int>(time * 1000 + 0.5); ++n) {
      now += std::chrono::milliseconds(1);
      drive.update(now, out);
      drive.step(1e-3);
    }
    return out;
  }
  void close() {
    tell(makeFloats(0x0F, 10, 5));
    tell(makeFloats(0x0C, floatAt(ask(0x09), 0), 0));
    tell(makeFrame(kNode * 32 + 0x07, {8, 0, 0, 0}));
  }
  Time now{std::chrono::seconds(1)};
  SimulatedOdrive drive;
};

SimulatedOdrive::Parameters withoutWatchdog() {
  SimulatedOdrive::Parameters p;
  p.watchdog_enabled = false;
  return p;
}

// ODrive documentation, "CAN Bus Guide", verifying communication: ten heartbeats a second, of an idle axis.
TEST(SimulatedOdrive, BeatsByItself) {
  Bench b(withoutWatchdog());
  const std::vector<CanFrame> beats = b.pass(1.0);
  EXPECT_EQ(beats.size(), 10u);
  EXPECT_TRUE(beats[0] == makeFrame(0x061, {0, 0, 0, 0, 1, 0, 0, 0}));
}

TEST(SimulatedOdrive, HearsOnlyItsOwnNode) {
  Bench b(withoutWatchdog());
  EXPECT_TRUE(b.tell(makeRemote((kNode + 1) * 32 + 9, 0)).empty());
  EXPECT_EQ(b.tell(makeRemote(kNode * 32 + 9, 0)).size(), 1u);
  EXPECT_TRUE(b.tell(makeRemote(kNode * 32 + 0x1F, 0)).empty());
}

TEST(SimulatedOdrive, CountsTurnsOfTheMotorFromWhereItWasSwitchedOn) {
  SimulatedOdrive::Parameters p = withoutWatchdog();
  p.gear_ratio = 4;
  Bench b(p);
  b.drive.setShaftAngle(kTwoPi / 2);
  EXPECT_NEAR(floatAt(b.ask(0x09), 0), 2, 1e-6);
  b.drive.powerCycle();
  EXPECT_TRUE(b.pass(0.79).empty());
  EXPECT_TRUE(b.tell(makeRemote(kNode * 32 + 9, 0)).empty()) << "still starting";
  EXPECT_FALSE(b.pass(0.1).empty());
  EXPECT_NEAR(floatAt(b.ask(0x09), 0), 0, 1e-6);
}

TEST(SimulatedOdrive, FollowsWithinItsLimits) {
  Bench b(withoutWatchdog());
  b.close();
  EXPECT_TRUE(b.drive.energised(0));
  b.tell(makeFloats(0x0F, 1, 2));  // 1 turn/s, 2 A = 1 N m
  b.tell(makeFloats(0x0C, 5, 0));
  b.pass(1.0);
  EXPECT_NEAR(b.drive.shaftAngle(0), kTwoPi, 0.02 * kTwoPi);
  b.drive.setLoadTorque(0, -3);
  b.pass(0.01);
  EXPECT_NEAR(b.drive.motorTorque(), 1, 1e-9);
  EXPECT_NEAR(floatAt(b.ask(0x14), 4), 2, 1e-6);
  EXPECT_LT(b.drive.shaftAngle(0), kTwoPi) << "dragged back";
}

TEST(SimulatedOdrive, ATrapezoidStartsAndArrivesAtRest) {
  Bench b(withoutWatchdog());
  b.close();
  b.tell(makeFrame(kNode * 32 + 0x0B, {3, 0, 0, 0, 5, 0, 0, 0}));
  b.tell(makeFloats(0x11, 2, 0));
  b.tell(makeFloats(0x12, 4, 4));
  b.tell(makeFloats(0x0C, 2, 0));
  b.pass(0.25);  // 4/2 t^2 turns
  EXPECT_NEAR(b.drive.shaftAngle(0) / kTwoPi, 0.125, 0.02);
  b.pass(0.75);  // half a second up, half a second at 2 turn/s
  EXPECT_NEAR(b.drive.shaftAngle(0) / kTwoPi, 1.5, 0.03);
  b.pass(1.0);
  EXPECT_NEAR(b.drive.shaftAngle(0) / kTwoPi, 2, 1e-3);
}

TEST(SimulatedOdrive, AStaleSetPointMovesTheShaft) {
  Bench b(withoutWatchdog());
  b.drive.setShaftAngle(3);
  b.tell(makeFloats(0x0F, 10, 5));
  b.tell(makeFrame(kNode * 32 + 0x07, {8, 0, 0, 0}));
  b.pass(0.5);
  EXPECT_NEAR(b.drive.shaftAngle(0), 0, 0.01);
}

TEST(SimulatedOdrive, ItsWatchdogActsUnlessFed) {
  Bench b;
  b.close();
  for (int n = 0; n < 20; ++n) {
    b.pass(0.05);
    b.tell(makeFloats(0x0C, 0, 0));
    ASSERT_TRUE(b.drive.energised(0));
  }
  b.pass(0.102);
  EXPECT_FALSE(b.drive.energised(0));
  EXPECT_EQ(b.drive.error(), 0x1000000u);
  b.tell(makeFrame(kNode * 32 + 0x07, {8, 0, 0, 0}));
  EXPECT_FALSE(b.drive.energised(0)) << "errors are to be cleared first";
  b.tell(makeFrame(kNode * 32 + 0x18, {}));
  b.tell(makeFrame(kNode * 32 + 0x07, {8, 0, 0, 0}));
  EXPECT_TRUE(b.drive.energised(0));
}

TEST(SimulatedOdrive, DisarmsWhenHotFeebleOrTold) {
  for (const int kind : {0, 1, 2}) {
    Bench b(withoutWatchdog());
    b.close();
    if (kind == 0) b.drive.setTemperature(130);
    if (kind == 1) b.drive.setSupplyVoltage(9);
    if (kind == 2) b.tell(makeFrame(kNode * 32 + 0x02, {}));
    b.pass(0.002);
    EXPECT_FALSE(b.drive.energised(0)) << kind;
    EXPECT_NE(b.drive.error(), 0u) << kind;
  }
}

TEST(SimulatedOdrive, IsSilentWithoutSupplyAndForgetsEverything) {
  Bench b(withoutWatchdog());
  b.close();
  b.tell(makeFloats(0x0C, 1, 0));
  b.pass(1);
  b.drive.setSupplyVoltage(5);
  EXPECT_TRUE(b.pass(0.5).empty());
  EXPECT_TRUE(b.tell(makeRemote(kNode * 32 + 9, 0)).empty());
  b.drive.setSupplyVoltage(24);
  b.pass(0.9);
  EXPECT_EQ(b.drive.state(), 1);
  EXPECT_NEAR(floatAt(b.ask(0x09), 0), 0, 1e-6);
  EXPECT_EQ(b.drive.currentLimit(), 20);
}

TEST(SimulatedOdrive, WatchdogSettingsAreBehindTheirEndpoints) {
  SimulatedOdrive::Parameters p = withoutWatchdog();
  p.enable_endpoint = 0x123;
  p.timeout_endpoint = 0x124;
  Bench b(p);
  b.tell(makeFrame(kNode * 32 + 4, {1, 0x24, 0x01, 0, 0, 0, 0, 0x3F}));
  b.tell(makeFrame(kNode * 32 + 4, {1, 0x23, 0x01, 0, 1}));
  EXPECT_EQ(b.drive.watchdogTimeout(), 0.5);
  const std::vector<CanFrame> out = b.tell(makeFrame(kNode * 32 + 4, {0, 0x24, 0x01, 0}));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_TRUE(out[0] == makeFrame(kNode * 32 + 5, {0, 0x24, 0x01, 0, 0, 0, 0, 0x3F}));
  EXPECT_TRUE(b.tell(makeFrame(kNode * 32 + 4, {0, 0x25, 0x01, 0})).empty());
}

}  // namespace
}  // namespace sinew
