#include "sinew/hardware/servo_chain.h"

#include <gtest/gtest.h>

#include "hardware/driver_bench.h"

namespace sinew {
namespace {

namespace reg = servo_register;
using Progress = SetUpProgress;

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
        chain(description, 0, [this](std::string&) { return std::shared_ptr<ByteStream>(&line, [](ByteStream*) {}); }) {
    std::string why;
    chain.open(why);
  }
  Progress setUp() {
    chain.startSetUp(false);
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
  bool write(const std::vector<double>& set_points) { return chain.writeSetPoints(set_points.data(), line.now()); }
  bool zerosValid() const {
    const auto& r = chain.readings();
    return std::all_of(r.begin(), r.end(), [](const ActuatorReading& one) { return one.zero_valid; });
  }
  bool well() const {
    const auto& r = chain.readings();
    return std::all_of(r.begin(), r.end(), [](const ActuatorReading& one) { return one.fault == 0; });
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
  EXPECT_FALSE(b.zerosValid());
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
  EXPECT_TRUE(b.zerosValid());
  for (int n = 0; n < 200; ++n) {
    ASSERT_TRUE(b.write({0.005, -0.005}) && b.chain.read(b.line.now()));
    b.pass();
  }
  EXPECT_NEAR(b.chain.readings()[0].measured, 0.005, 2e-5);
  EXPECT_NEAR(b.chain.readings()[1].measured, -0.005, 2e-5);
  EXPECT_TRUE(b.well());
  b.bus.setFrozen(1, true);
  for (int n = 0; n < 12; ++n) {
    b.chain.read(b.line.now());
    b.pass();
  }
  EXPECT_FALSE(b.chain.readings()[1].valid);
  EXPECT_NEAR(b.chain.readings()[1].measured, -0.005, 2e-5);
  EXPECT_FALSE(b.well());
  EXPECT_EQ(b.chain.readings()[1].fault, kFaultSilent);
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
  EXPECT_FALSE(b.well());
  EXPECT_NE(b.chain.readings()[1].fault & kFaultOff, 0u);
  ASSERT_EQ(b.setUp(), Progress::kDone) << b.chain.problem();
  EXPECT_TRUE(b.chain.readings()[0].zero_valid);
  EXPECT_FALSE(b.chain.readings()[1].zero_valid);
}

// A driver that is killed and started again finds servos that have kept counting.
TEST(ServoChain, AnEarlierLifesZeroHoldsUnlessTheServoHasRestarted) {
  Bench first(2);
  ASSERT_EQ(first.setUp(), Progress::kDone);
  first.chain.read(first.line.now());
  first.chain.setZero(0, 0.004);
  first.chain.setZero(1, 0.004);
  const double zeros[2] = {first.chain.zeroCounts(0), first.chain.zeroCounts(1)};
  first.bus.powerCycle(1);

  ServoChain second(first.description, 0,
                    [&](std::string&) { return std::shared_ptr<ByteStream>(&first.line, [](ByteStream*) {}); });
  std::string why;
  ASSERT_TRUE(second.open(why));
  for (int i = 0; i < 2; ++i) second.restoreZero(i, zeros[i]);
  second.startSetUp(false);
  Progress progress = Progress::kBusy;
  for (int n = 0; n < 500 && progress == Progress::kBusy; ++n) {
    progress = second.updateSetUp(first.line.now());
    first.pass();
  }
  ASSERT_EQ(progress, Progress::kDone) << second.problem();
  second.read(first.line.now());
  EXPECT_TRUE(second.readings()[0].zero_valid);
  EXPECT_NEAR(second.readings()[0].measured, 0.004, 2e-5);
  EXPECT_FALSE(second.readings()[1].zero_valid) << "it has lost its turns";
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
  EXPECT_NE(b.chain.readings()[0].fault & kFaultJumped, 0u);
}

TEST(ServoChain, RelaxesByShareOfWhatItHadAndSwitchesOff) {
  Bench b(2);
  ASSERT_EQ(b.setUp(), Progress::kDone);
  for (int i = 0; i < 2; ++i) b.bus.setLoadTorque(i, -0.01 * 5);
  b.pass();
  ASSERT_TRUE(b.chain.read(b.line.now()));
  ASSERT_NEAR(b.chain.readings()[1].effort, 5, 0.5);
  ASSERT_TRUE(b.chain.relax({false, true}, 1));
  EXPECT_EQ(b.bus.servo(0).value(reg::kGoalCurrent), 41) << "its own limit: floor(20 * 0.01 / 1.7826 / 0.00269)";
  EXPECT_NEAR(b.bus.servo(1).value(reg::kGoalCurrent), 10, 1) << "5 N";
  ASSERT_TRUE(b.chain.relax({false, true}, 0.5));
  EXPECT_NEAR(b.bus.servo(1).value(reg::kGoalCurrent), 5, 1);
  ASSERT_TRUE(b.chain.switchOff({false, true}));
  EXPECT_TRUE(b.bus.torqueEnabled(0));
  EXPECT_FALSE(b.bus.torqueEnabled(1));
}

TEST(ServoChain, MixesModelsWithOtherControlTables) {
  const HardwareDescription description = HardwareDescription::parse(makeHardwareYaml(3), "bench");
  SimulatedServoBus bus({1, 2, 3}, 1000000, {{}, SimulatedServo::Parameters::makeXl330M288(), {}});
  SimulatedLine line(bus);
  ServoChain chain(description, 0,
                   [&](std::string&) { return std::shared_ptr<ByteStream>(&line, [](ByteStream*) {}); });
  std::string why;
  ASSERT_TRUE(chain.open(why));
  chain.startSetUp(true);
  Progress progress = Progress::kBusy;
  for (int n = 0; n < 500 && progress == Progress::kBusy; ++n) {
    progress = chain.updateSetUp(line.now());
    line.advanceTo(line.now() + duration(0.01));
    bus.step(0.01);
  }
  ASSERT_EQ(progress, Progress::kDone) << chain.problem();
  EXPECT_EQ(bus.servo(1).value(reg::kGoalCurrent), 112) << "floor(20 * 0.01 / 1.7826 / 0.001): mA, not 2.69 mA";
  bus.setShaftAngle(1, 0.2);
  const std::vector<double> still = {0, 0.002, 0};
  for (int n = 0; n < 5; ++n) {
    ASSERT_TRUE(chain.writeSetPoints(still.data(), line.now()) && chain.read(line.now()));
    line.advanceTo(line.now() + duration(0.01));
    bus.step(0.01);
  }
  for (const ActuatorReading& r : chain.readings()) EXPECT_TRUE(r.valid);
  EXPECT_NEAR(chain.readings()[1].measured, 0.002, 3e-5);
  EXPECT_NEAR(chain.readings()[1].voltage, 5, 0.05);
  EXPECT_EQ(chain.readings()[1].fault, 0u) << "5 V is no dip for it";
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
