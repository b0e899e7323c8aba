#include "sinew/hardware/servo_chain.h"

#include <gtest/gtest.h>

#include "hardware/driver_bench.h"

namespace sinew {
namespace {

namespace reg = servo_register;
using Progress = ServoChain::Progress;

std::vector<std::uint8_t> firstIds(int count) {
  std::vector<std::uint8_t> ids;
  for (int i = 1; i <= count; ++i) ids.push_back(static_cast<std::uint8_t>(i));
  return ids;
}

struct Bench {
  explicit Bench(int servos, int present = -1)
      : description(HardwareDescription::parse(makeHardwareYaml(servos), "bench")),
        bus(firstIds(present < 0 ? servos : present)),
        line(bus),
        chain(description) {
    chain.attach(&line);
  }
  Progress setUp() {
    chain.startSetUp();
    Progress progress = Progress::kBusy;
    for (int n = 0; n < 500 && progress == Progress::kBusy; ++n) {
      progress = chain.updateSetUp(line.now());
      pass();
    }
    return progress;
  }
  void pass(double time = 0.01) {
    line.advanceTo(line.now() + duration(time));
    bus.step(time);
  }
  HardwareDescription description;
  SimulatedServoBus bus;
  SimulatedLine line;
  ServoChain chain;
};

TEST(ServoChain, SetUpLeavesEveryServoArmedInMode5AtItsPosition) {
  Bench b(3);
  for (int i = 0; i < 3; ++i) b.bus.setShaftAngle(i, 2.0 * i + 0.1);
  ASSERT_EQ(b.setUp(), Progress::kDone) << b.chain.problem();
  for (int i = 0; i < 3; ++i) {
    const SimulatedServo s = b.bus.servo(i);
    EXPECT_EQ(s.value(reg::kOperatingMode), 5);
    EXPECT_EQ(s.value(reg::kTorqueEnable), 1);
    EXPECT_EQ(s.value(reg::kBusWatchdog), 5);
    EXPECT_EQ(s.value(reg::kReturnDelay), 0);
    EXPECT_NEAR(s.shaftAngle(), 2.0 * i + 0.1, 0.51 * kRadiansPerCount);
  }
  EXPECT_FALSE(b.chain.zerosValid());
}

TEST(ServoChain, NamesTheServoThatIsMissing) {
  Bench b(3, 2);
  EXPECT_EQ(b.setUp(), Progress::kFailed);
  EXPECT_NE(b.chain.problem().find("cable_3 (id 3)"), std::string::npos) << b.chain.problem();
}

TEST(ServoChain, ReadsWritesAndKeepsTheLastReadingOfASilentServo) {
  Bench b(2);
  ASSERT_EQ(b.setUp(), Progress::kDone);
  ASSERT_TRUE(b.chain.read(b.line.now()));
  b.chain.setZero(0, 0);
  b.chain.setZero(1, 0);
  EXPECT_TRUE(b.chain.zerosValid());
  for (int n = 0; n < 200; ++n) {
    ASSERT_TRUE(b.chain.writeSetPoints({0.005, -0.005}) && b.chain.read(b.line.now()));
    b.pass();
  }
  EXPECT_NEAR(b.chain.readings()[0].displacement, 0.005, 2e-5);
  EXPECT_NEAR(b.chain.readings()[1].displacement, -0.005, 2e-5);
  EXPECT_TRUE(b.chain.checkHealth());
  b.bus.setFrozen(1, true);
  for (int n = 0; n < 12; ++n) {
    b.chain.read(b.line.now());
    b.pass();
  }
  EXPECT_FALSE(b.chain.readings()[1].valid);
  EXPECT_NEAR(b.chain.readings()[1].displacement, -0.005, 2e-5);
  EXPECT_FALSE(b.chain.checkHealth());
  EXPECT_NE(b.chain.problem().find("cable_2 (id 2) does not answer"), std::string::npos) << b.chain.problem();
}

TEST(ServoChain, AnAnswerOfTheWrongTimeIsNotBelieved) {
  Bench b(1);
  ASSERT_EQ(b.setUp(), Progress::kDone);
  ASSERT_TRUE(b.chain.read(b.line.now()));
  ASSERT_TRUE(b.chain.readings()[0].valid);
  b.pass();
  // Asked "now" 50 ms after the last reading, answered with a clock that has moved by 10 ms.
  b.chain.read(b.line.now() + std::chrono::milliseconds(40));
  EXPECT_FALSE(b.chain.readings()[0].valid);
  EXPECT_GE(b.chain.counters().stale, 1u);
}

TEST(ServoChain, ARestartedServoIsNoticedAndItsZeroIsGone) {
  Bench b(2);
  ASSERT_EQ(b.setUp(), Progress::kDone);
  b.chain.read(b.line.now());
  b.chain.setZero(0, 0);
  b.chain.setZero(1, 0);
  b.bus.powerCycle(1);
  b.pass();
  b.chain.read(b.line.now());
  EXPECT_FALSE(b.chain.checkHealth());
  EXPECT_NE(b.chain.problem().find("restarted"), std::string::npos) << b.chain.problem();
  ASSERT_EQ(b.setUp(), Progress::kDone) << b.chain.problem();
  EXPECT_TRUE(b.chain.readings()[0].zero_valid);
  EXPECT_FALSE(b.chain.readings()[1].zero_valid);
}

TEST(ServoChain, AJumpMakesTheZeroInvalid) {
  Bench b(1);
  ASSERT_EQ(b.setUp(), Progress::kDone);
  b.chain.read(b.line.now());
  b.chain.setZero(0, 0);
  b.bus.setShaftAngle(0, b.bus.shaftAngle(0) + 2 * kPi);
  b.pass();
  b.chain.read(b.line.now());
  EXPECT_FALSE(b.chain.readings()[0].zero_valid);
  EXPECT_NE(b.chain.readings()[0].fault & kServoJumped, 0u);
}

TEST(ServoChain, TensionLimitsAndRelease) {
  Bench b(2);
  ASSERT_EQ(b.setUp(), Progress::kDone);
  ASSERT_TRUE(b.chain.writeTensionLimits({5, 500}));
  EXPECT_EQ(b.bus.servo(0).value(reg::kGoalCurrent), 10);  // floor(5 * 0.01 / 1.7826 / 0.00269)
  EXPECT_EQ(b.bus.servo(1).value(reg::kGoalCurrent), 41) << "never above its own limit";
  ASSERT_TRUE(b.chain.release({false, true}));
  EXPECT_TRUE(b.bus.torqueEnabled(0));
  EXPECT_FALSE(b.bus.torqueEnabled(1));
}

TEST(ServoChain, SetUpSurvivesABadLine) {
  Bench b(8);
  LineFaults faults;
  faults.corrupt = faults.drop = 0.02;
  b.bus.setLineFaults(faults);
  EXPECT_EQ(b.setUp(), Progress::kDone) << b.chain.problem();
}

}  // namespace
}  // namespace sinew
