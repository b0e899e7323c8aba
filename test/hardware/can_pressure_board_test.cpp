#include "sinew/hardware/can_pressure_board.h"

#include <gtest/gtest.h>

#include <cmath>

#include "hardware/pressure_bench.h"
#include "sinew/hardware/simulated_pressure_node.h"

namespace sinew {
namespace {

/// A board, its simulated counterpart, and a bus that carries frames at once.
struct CanBench : CanSender {
  CanBench() : node(11, {0, 2}), device(11, makePressureTiming(), makePressureActuators(2)) {}

  bool send(const CanFrame& frame) override {
    sent.push_back(frame);
    if (!lost) node.take(frame, now, inbox);
    return true;
  }

  void deliver() {
    for (std::size_t i = 0; i < inbox.size(); ++i)
      if (static_cast<int>(i) != lose_answer) taken += device.take(inbox[i], now) ? 1 : 0;
    inbox.clear();
  }

  void pass() {
    node.step(kPressurePeriod);
    now += duration(kPressurePeriod);
  }

  SetUpProgress setUp() {
    device.startSetUp(true);
    SetUpProgress progress = SetUpProgress::kBusy;
    for (int n = 0; n < 200 && progress == SetUpProgress::kBusy; ++n) {
      progress = device.updateSetUp(now, *this);
      deliver();
      pass();
    }
    for (std::size_t i = 0; i < 2; ++i) set_points[i] = device.readings()[i].measured;
    return progress;
  }

  void cycle() {
    device.writeSetPoints(set_points, now, *this);
    device.request(now, *this);
    deliver();
    device.endCycle(now);
    pass();
  }
  void cycles(int count) {
    for (int n = 0; n < count; ++n) cycle();
  }
  void moveTo(double target, int count) {
    for (int n = 0; n < count; ++n) {
      for (double& s : set_points) s += std::clamp(target - s, -800., 800.);
      cycle();
    }
  }
  std::uint32_t fault(std::size_t i) const { return device.readings()[i].fault; }

  SimulatedPressureNode node;
  CanPressureBoard device;
  Time now{std::chrono::seconds(1)};
  std::vector<CanFrame> inbox, sent;
  bool lost = false;     // requests
  int lose_answer = -1;  // this frame of every answer
  int taken = 0;
  double set_points[2] = {};  // Pa gauge
};

TEST(CanPressureBoard, SetUpMovesNothingAndFollowsSetPoints) {
  CanBench b;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.device.problem();
  b.cycles(20);
  EXPECT_NEAR(b.node.pressure(0), 0, 1);
  EXPECT_TRUE(b.node.energised(0) && b.node.energised(1));
  b.moveTo(40000, 200);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(b.node.pressure(i), 40000, 150);
    EXPECT_NEAR(b.device.readings()[static_cast<std::size_t>(i)].measured, 40000, 150);
    EXPECT_EQ(b.fault(static_cast<std::size_t>(i)), 0u);
  }
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.device.problem();
  b.cycles(100);
  EXPECT_NEAR(b.node.pressure(0), 40000, 300) << "again, under pressure";
  EXPECT_EQ(b.device.counters().missing + b.device.counters().corrupted + b.device.counters().stale, 0u);
}

TEST(CanPressureBoard, SpeaksOnlyExtendedFramesOfItsOwn) {
  CanBench b;
  b.setUp();
  b.cycles(3);
  for (const CanFrame& f : b.sent) {
    EXPECT_TRUE(f.extended);
    EXPECT_EQ(f.id & 0x1F00FF00u, 0x15000B00u);
  }
  CanFrame other;
  other.id = 0x15840C00;
  other.extended = true;
  other.size = 8;
  EXPECT_FALSE(b.device.take(other, b.now)) << "another board's";
  other.id = 0x080;
  other.extended = false;
  EXPECT_FALSE(b.device.take(other, b.now)) << "SYNC";
}

TEST(CanPressureBoard, SilentMasterRestartAndSilentBoard) {
  CanBench b;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(40000, 150);
  for (int n = 0; n < 21; ++n) b.pass();
  EXPECT_FALSE(b.node.energised(0));
  b.cycle();
  EXPECT_NE(b.fault(0) & kFaultWatchdog, 0u);

  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.device.problem();
  b.moveTo(40000, 100);
  b.node.powerCycle();
  b.cycle();
  EXPECT_NE(b.fault(1) & kFaultOff, 0u);
  b.cycles(200);
  EXPECT_LT(b.node.pressure(0), 10);

  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.node.setFrozen(true);
  b.cycles(10);
  EXPECT_EQ(b.fault(0), kFaultSilent);
  EXPECT_FALSE(b.device.readings()[0].valid);
  EXPECT_EQ(b.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(b.device.problem().find("does not answer"), std::string::npos);
}

TEST(CanPressureBoard, AStateWithAPartMissingIsNoReading) {
  for (const int missing : {0, 2, 3, 4, 5}) {
    CanBench b;
    ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
    b.cycles(5);
    b.lose_answer = missing;  // of four channels, the board's frame and the last one
    b.cycles(3);
    EXPECT_FALSE(b.device.readings()[0].valid) << missing;
    b.lose_answer = -1;
    b.cycle();
    EXPECT_TRUE(b.device.readings()[0].valid) << missing;
    EXPECT_EQ(b.fault(0), 0u);
  }
}

TEST(CanPressureBoard, RelaxesAndSwitchesOff) {
  CanBench b;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(40000, 150);
  const bool which[] = {true, false};
  for (int n = 0; n <= 100; ++n) {
    b.device.relax(which, 1 - 0.01 * n, b);
    b.device.request(b.now, b);
    b.deliver();
    b.device.endCycle(b.now);
    b.pass();
  }
  EXPECT_LT(b.node.pressure(0), 4000);
  EXPECT_FALSE(b.node.energised(0));
  EXPECT_NEAR(b.node.pressure(1), 40000, 300);
  const bool both[] = {true, true};
  b.device.switchOff(both, b);
  EXPECT_FALSE(b.node.energised(1));
}

TEST(CanPressureBoard, StaysOnWhileItsBusWaitsForOtherDevices) {
  CanBench b;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  for (int n = 0; n < 100; ++n) {
    EXPECT_EQ(b.device.updateSetUp(b.now, b), SetUpProgress::kDone);
    b.deliver();
    b.pass();
  }
  b.cycle();
  EXPECT_EQ(b.fault(0), 0u) << b.device.faultDetail(0);
}

}  // namespace
}  // namespace sinew
