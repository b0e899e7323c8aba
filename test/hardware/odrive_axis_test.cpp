#include "sinew/hardware/odrive_axis.h"

#include <gtest/gtest.h>

#include "hardware/odrive_bench.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kTwoPi = 6.283185307179586;

TEST(OdriveAxis, SetUpMovesNothingAndLeavesEveryAxisArmed) {
  OdriveBench b(4);
  for (int i = 0; i < 4; ++i) b.drive(i).setShaftAngle(0.7 * i);
  for (int i = 0; i < 4; ++i) b.line->setLoadTorque(i, 0);
  std::vector<double> angles;
  // Without load: a limp spool with a taut cable slips, whatever its driver does.
  b.bus->startSetUp(false);
  SetUpProgress progress = SetUpProgress::kBusy;
  for (int n = 0; n < 1000 && progress == SetUpProgress::kBusy; ++n) {
    progress = b.bus->updateSetUp(b.port->now());
    b.port->advanceTo(b.port->now() + duration(OdriveBench::kPeriod));
    for (int i = 0; i < 4; ++i) b.line->setLoadTorque(i, 0);
    b.line->step(OdriveBench::kPeriod);
    for (int i = 0; i < 4; ++i) angles.push_back(b.line->shaftAngle(i));
  }
  ASSERT_EQ(progress, SetUpProgress::kDone) << b.bus->problem();
  for (std::size_t k = 0; k < angles.size(); ++k)
    EXPECT_NEAR(angles[k], 0.7 * static_cast<double>(k % 4), 1e-6) << "float32 turns are the only source";
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(b.drive(i).state(), 8);
    EXPECT_EQ(b.drive(i).error(), 0u);
    EXPECT_GT(b.drive(i).watchdogTimeout(), 0);
    EXPECT_FALSE(b.reading(i).zero_valid);
    EXPECT_NEAR(b.drive(i).currentLimit(), 20 * 0.01 / 0.5, 1e-6);
    EXPECT_NEAR(b.drive(i).velocityLimit(), 1.5 * 0.1 / (kTwoPi * 0.01), 1e-5);
  }
}

TEST(OdriveAxis, UnderLoadTheCableStaysWhereTheLoopFoundIt) {
  OdriveBench b(2);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus->problem();
  const double at = b.reeled(0);
  b.run({b.reading(0).measured, b.reading(1).measured}, 50);
  EXPECT_NEAR(b.reeled(0), at, 1e-6);
}

TEST(OdriveAxis, FollowsAndReadsEverything) {
  OdriveBench b(2);
  ASSERT_TRUE(b.start()) << b.bus->problem();
  const double start[] = {b.reeled(0), b.reeled(1)};
  ASSERT_TRUE(b.run({0.02, -0.004}, 300));
  EXPECT_NEAR(b.reeled(0) - start[0], 0.02, 1e-5);
  EXPECT_NEAR(b.reeled(1) - start[1], -0.004, 1e-5);
  for (int i = 0; i < 2; ++i) {
    const ActuatorReading& r = b.reading(i);
    EXPECT_TRUE(r.valid);
    EXPECT_TRUE(r.zero_valid);
    EXPECT_EQ(r.fault, 0u);
    EXPECT_NEAR(r.measured, b.reeled(i) - start[i], 1e-5);
    EXPECT_NEAR(r.effort, b.tension(i), 0.01) << i;
    EXPECT_NEAR(r.current, b.tension(i) * OdriveBench::kRadius / OdriveBench::kConstant, 1e-3) << "positive reeling in";
    EXPECT_NEAR(r.voltage, 24, 1e-3);
    EXPECT_NEAR(r.temperature, 30, 1e-3);
    EXPECT_EQ(r.missing, 0);
  }
  EXPECT_EQ(b.bus->counters().missing + b.bus->counters().stale + b.bus->counters().corrupted, 0u);
}

TEST(OdriveAxis, AGearIsBetweenMotorAndSpool) {
  OdriveBench::Options options;
  options.settings.gear_ratio = options.parameters.gear_ratio = 9;
  OdriveBench b(options);
  ASSERT_TRUE(b.start()) << b.bus->problem();
  const double start = b.reeled(0);
  b.run({0.01, 0}, 200);
  EXPECT_NEAR(b.reeled(0) - start, 0.01, 1e-5);
}

TEST(OdriveAxis, TheDeviceBoundsTheTension) {
  OdriveBench b(1);
  ASSERT_TRUE(b.start());
  b.run({0.3}, 400);  // would be 60 N
  EXPECT_NEAR(b.tension(0), OdriveBench::kTensionMax, 0.01);
  EXPECT_NEAR(b.reading(0).effort, OdriveBench::kTensionMax, 0.01);
}

TEST(OdriveAxis, TheDeviceBoundsTheSpeed) {
  OdriveBench b(1);
  ASSERT_TRUE(b.start());
  const double before = b.reeled(0);
  b.run({0.05}, 10);
  EXPECT_LE(b.reeled(0) - before, 1.5 * 0.1 * 10 * OdriveBench::kPeriod * 1.01);
  EXPECT_GE(b.reeled(0) - before, 0.1 * 8 * OdriveBench::kPeriod);
}

TEST(OdriveAxis, ATrapezoidalInputFollowsToo) {
  OdriveBench::Options options;
  options.settings.input = OdriveInput::kTrapezoidal;
  options.settings.acceleration = 1;
  OdriveBench b(options);
  ASSERT_TRUE(b.start());
  EXPECT_EQ(b.drive(0).inputMode(), 5);
  const double before = b.reeled(0);
  b.run({0.02, 0}, 300);
  EXPECT_NEAR(b.reeled(0) - before, 0.02, 1e-4);
}

TEST(OdriveAxis, EstimatesMayComeByThemselves) {
  OdriveBench::Options options;
  options.settings.cyclic = true;
  options.parameters.cyclic = 0.005;
  OdriveBench b(options);
  ASSERT_TRUE(b.start()) << b.bus->problem();
  const double before = b.reeled(0);
  b.run({0.01, 0.01}, 300);
  EXPECT_TRUE(b.reading(0).valid);
  EXPECT_NEAR(b.reading(0).measured, b.reeled(0) - before, 1e-5);
  EXPECT_NEAR(b.reading(0).effort, b.tension(0), 0.01);
  EXPECT_EQ(b.reading(0).fault, 0u);
}

TEST(OdriveAxis, TheWatchdogStopsItWhenTheMasterFallsSilent) {
  OdriveBench b(2);
  ASSERT_TRUE(b.start());
  b.run({0.01, 0.01}, 100);
  int silent = 0;
  for (; b.line->energised(0) || b.line->energised(1); ++silent) {
    b.pass();
    ASSERT_LT(silent, 100);
  }
  EXPECT_LE(silent, 12) << "cycles of 10 ms, with a watchdog of 100 ms";
  EXPECT_EQ(b.drive(0).error(), 0x1000000u);
  EXPECT_LE(b.cyclesUntil(0, kFaultWatchdog, {0.01, 0.01}), OdriveBench::kMissingLimit + 1);
  EXPECT_LE(b.cyclesUntil(0, kFaultOff, {0.01, 0.01}), OdriveBench::kMissingLimit + 1);
  EXPECT_TRUE(b.reading(0).zero_valid);
  EXPECT_NE(b.bus->faultDetail(0).find("watchdog"), std::string::npos) << b.bus->faultDetail(0);
}

TEST(OdriveAxis, RefusesAnAxisWithoutAWatchdog) {
  for (const double timeout : {0., 2.}) {
    OdriveBench::Options options;
    options.parameters.watchdog_enabled = timeout > 0;
    options.parameters.watchdog_timeout = timeout;
    OdriveBench b(options);
    EXPECT_EQ(b.setUp(), SetUpProgress::kFailed) << timeout;
    EXPECT_NE(b.bus->problem().find("cable_1 (ODrive node 1) has no watchdog"), std::string::npos) << b.bus->problem();
    EXPECT_FALSE(b.line->energised(0));
  }
}

TEST(OdriveAxis, ArmsTheWatchdogItselfWhereItMay) {
  OdriveBench::Options options;
  options.settings.watchdog.given = true;
  options.settings.watchdog.enable = options.parameters.enable_endpoint = 268;
  options.settings.watchdog.timeout = options.parameters.timeout_endpoint = 269;
  options.parameters.watchdog_enabled = false;
  options.parameters.watchdog_idle = false;
  OdriveBench b(options);
  ASSERT_TRUE(b.start()) << b.bus->problem();
  EXPECT_NEAR(b.drive(0).watchdogTimeout(), 0.1, 1e-6);
  b.run({0, 0}, 10);
  for (int n = 0; n < 12; ++n) b.pass();
  EXPECT_FALSE(b.line->energised(0));

  options.settings.watchdog.timeout = 270;
  OdriveBench wrong(options);
  EXPECT_EQ(wrong.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(wrong.bus->problem().find("endpoint 270"), std::string::npos) << wrong.bus->problem();
}

TEST(OdriveAxis, SpeaksWithTheOlderFirmware) {
  OdriveBench::Options options;
  options.settings.firmware = OdriveFirmware::k05;
  options.parameters.firmware05 = true;
  OdriveBench b(options);
  ASSERT_TRUE(b.start()) << b.bus->problem();
  b.run({0.01, 0.01}, 100);
  EXPECT_EQ(b.reading(0).fault, 0u);
  EXPECT_NEAR(b.reading(0).voltage, 24, 1e-3);
  for (int n = 0; n < 12; ++n) b.pass();
  EXPECT_LE(b.cyclesUntil(0, kFaultWatchdog, {0.01, 0.01}), OdriveBench::kMissingLimit + 1);

  options.settings.firmware = OdriveFirmware::k06;
  OdriveBench wrong(options);
  EXPECT_EQ(wrong.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(wrong.bus->problem().find("firmware: \"0.5\""), std::string::npos) << wrong.bus->problem();
}

TEST(OdriveAxis, NamesWhatKeepsItFromBeingSetUp) {
  OdriveBench absent(2);
  absent.line->setFrozen(1, true);
  EXPECT_EQ(absent.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(absent.bus->problem().find("cable_2 (ODrive node 2) is not heard"), std::string::npos)
      << absent.bus->problem();
  OdriveBench hot(2);
  hot.line->setTemperature(0, 120);
  EXPECT_EQ(hot.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(hot.bus->problem().find("inverter over temp"), std::string::npos) << hot.bus->problem();
}

TEST(OdriveAxis, RefusesATensionThatNoCurrentBoundsAndAHomingThatItHasNot) {
  OdriveBench b(1);
  WinchDescription cable;
  cable.spool_radius = 0.01;
  cable.torque_constant = 0.5;
  EXPECT_THROW(OdriveAxis(OdriveSettings(), cable, OdriveBench::makeBounds(0), b.makeTiming()), ConfigError);
  cable.tension_max = 20;
  EXPECT_NO_THROW(OdriveAxis(OdriveSettings(), cable, OdriveBench::makeBounds(0), b.makeTiming()));
  cable.homing.method = HomingMethod::kDevice;
  EXPECT_THROW(OdriveAxis(OdriveSettings(), cable, OdriveBench::makeBounds(0), b.makeTiming()), ConfigError);
}

struct FaultCase {
  const char* name;
  void (*strike)(OdriveBench&);
  std::uint32_t fault;
  bool zero_kept;
};

class OdriveFault : public testing::TestWithParam<FaultCase> {};

TEST_P(OdriveFault, IsShownWithinTheMissingLimitAndStays) {
  OdriveBench b(2);
  ASSERT_TRUE(b.start());
  b.run({0.01, 0.01}, 100);
  ASSERT_EQ(b.reading(0).fault, 0u);
  GetParam().strike(b);
  const int cycles = b.cyclesUntil(0, GetParam().fault, {0.01, 0.01});
  EXPECT_GT(cycles, 0) << std::hex << b.reading(0).fault;
  EXPECT_LE(cycles, OdriveBench::kMissingLimit + 1);
  b.run({0.01, 0.01}, 100);
  EXPECT_NE(b.reading(0).fault & GetParam().fault, 0u) << "until the next set-up";
  EXPECT_EQ(b.reading(0).zero_valid, GetParam().zero_kept);
  EXPECT_EQ(b.reading(1).fault != 0, std::string(GetParam().name) == "supply_dip") << "of both, or of the first alone";
}

INSTANTIATE_TEST_SUITE_P(
    Faults, OdriveFault,
    testing::Values(
        FaultCase{"frozen", [](OdriveBench& b) { b.line->setFrozen(0, true); }, kFaultSilent, true},
        FaultCase{"overheated", [](OdriveBench& b) { b.line->setTemperature(0, 120); }, kFaultOverheated, true},
        FaultCase{"supply_dip", [](OdriveBench& b) { b.line->setSupplyVoltage(9); }, kFaultUndervolted, false},
        FaultCase{"power_cycle", [](OdriveBench& b) { b.line->powerCycle(0); }, kFaultSilent, false},
        FaultCase{"encoder", [](OdriveBench& b) { b.drive(0).raise(8); }, kFaultEncoder, true},
        FaultCase{"jump", [](OdriveBench& b) { b.drive(0).setShaftAngle(b.line->shaftAngle(0) + 5); }, kFaultJumped,
                  false}),
    [](const testing::TestParamInfo<FaultCase>& one) { return std::string(one.param.name); });

TEST(OdriveAxis, RecoveryFromAHalfRelaxedHoldMovesNothing) {
  OdriveBench b(1);
  ASSERT_TRUE(b.start());
  b.run({0.05}, 200);
  const double taut = b.tension(0);
  ASSERT_TRUE(b.bus->relax({true}, 0.3));
  b.run({0.05}, 800);
  const double slipped = b.reeled(0);
  ASSERT_NEAR(b.tension(0), 0.3 * taut, 0.01);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus->problem();
  EXPECT_NEAR(b.reeled(0), slipped, 1e-6);
  EXPECT_TRUE(b.reading(0).zero_valid);
}

// What happens to the zero between one set-up and the next.
TEST(OdriveAxis, AZeroOutlivesARecoveryButNotARestart) {
  OdriveBench b(2);
  ASSERT_TRUE(b.start());
  b.run({0.01, 0.01}, 100);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus->problem();
  EXPECT_TRUE(b.reading(0).zero_valid) << "from a held position";
  EXPECT_NEAR(b.reading(0).measured, 0.01, 1e-5);
  b.line->powerCycle(0);
  for (int n = 0; n < 100; ++n) b.pass();  // nobody listens
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus->problem();
  EXPECT_FALSE(b.reading(0).zero_valid);
  EXPECT_EQ(b.reading(0).fault, 0u);
  ASSERT_EQ(b.setUp(true), SetUpProgress::kDone) << b.bus->problem();
  EXPECT_FALSE(b.reading(1).zero_valid) << "as asked";
}

TEST(OdriveAxis, AfterSilenceAZeroIsKeptOnlyWhereARestartWouldShow) {
  OdriveBench::Options options;
  options.axes = 1;
  options.settings.gear_ratio = options.parameters.gear_ratio = 10;
  options.parameters.friction = 0.1;  // the limp spool holds its cable
  for (const double far : {0.0, 0.03}) {
    OdriveBench b(options);
    ASSERT_TRUE(b.start());
    b.run({far}, 200);
    b.port->setPlugged(false);
    for (int n = 0; n < 300; ++n) b.cycle({far});
    b.port->setPlugged(true);
    CanFrame missed;
    while (b.port->receive(missed, Duration{0}) == StreamStatus::kOk) continue;
    ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus->problem();
    EXPECT_EQ(b.reading(0).zero_valid, far > 0);
    EXPECT_NEAR(b.reading(0).measured, far, 1e-4);
  }
}

// A driver in fault reads now and then; the heartbeats that have come meanwhile tell that nothing has restarted.
TEST(OdriveAxis, AZeroOutlivesAFaultWhoseHeartbeatsAreAllThere) {
  OdriveBench b(2);
  ASSERT_TRUE(b.start());
  b.run({0.005, 0.005}, 100);
  for (int n = 0; n < 10; ++n) {
    for (int k = 0; k < 70; ++k) b.pass();
    b.bus->read(b.port->now());
  }
  EXPECT_FALSE(b.line->energised(0));
  const double at = b.reading(0).measured;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus->problem();
  EXPECT_TRUE(b.reading(0).zero_valid);
  EXPECT_NEAR(b.reading(0).measured, at, 1e-3) << "the cable may creep off its limp spool";
}

TEST(OdriveAxis, RelaxesToNothingAndLetsGo) {
  OdriveBench b(2);
  ASSERT_TRUE(b.start());
  b.run({0.02, 0.02}, 100);
  const double before = std::abs(b.drive(0).motorTorque()), angle = b.reeled(0);
  ASSERT_TRUE(b.bus->relax({true, false}, 1));
  b.cycle({0.02, 0.02});
  EXPECT_NEAR(b.reeled(0), angle, 1e-6) << "the whole effort holds the cable";
  for (int n = 0; n <= 20; ++n) {
    ASSERT_TRUE(b.bus->relax({true, false}, 1 - n / 20.));
    b.cycle({0.02, 0.02});
    EXPECT_LE(std::abs(b.drive(0).motorTorque()), (1 - n / 20.) * before + 1e-6) << n;
  }
  EXPECT_GT(b.tension(1), 5);
  ASSERT_TRUE(b.bus->switchOff({true, false}));
  b.cycle({0.02, 0.02});
  EXPECT_FALSE(b.line->energised(0));
  EXPECT_TRUE(b.line->energised(1));
  b.run({0.02, 0.02}, 30);
  EXPECT_EQ(b.reading(0).fault, 0u) << "off as wished";
}

// Every message that was asked for is either used, or counted with its reason.
TEST(OdriveAxis, ABadLineIsAccountedFor) {
  OdriveBench::Options options;
  options.parameters.heartbeat = 1;  // hardly ever, so that nearly all are answers
  options.settings.heartbeat = 1;
  OdriveBench b(options);
  ASSERT_TRUE(b.start()) << b.bus->problem();
  const BusCounters before = b.bus->counters();
  LineFaults faults;
  faults.corrupt = faults.drop = faults.delay = faults.duplicate = 0.03;
  b.line->setLineFaults(faults);
  const LineFaultCounts counted = b.line->lineFaultCounts();
  int invalid = 0;
  constexpr int kCycles = 2000;
  for (int n = 0; n < kCycles; ++n) {
    b.cycle({0.01, 0.01});
    for (int i = 0; i < 2; ++i) {
      if (!b.reading(i).valid) ++invalid;
      ASSERT_NEAR(b.reading(i).measured, 0.01, n > 100 ? 1e-5 : 1) << "no wrong value is believed";
    }
  }
  const LineFaultCounts c = b.line->lineFaultCounts();
  const std::uint64_t gone = c.corrupted + c.dropped - counted.corrupted - counted.dropped;
  const std::uint64_t late = c.delayed - counted.delayed, twice = c.duplicated - counted.duplicated;
  const double heartbeats = 2 * kCycles * OdriveBench::kPeriod;
  EXPECT_NEAR(static_cast<double>(b.bus->counters().missing - before.missing), static_cast<double>(gone + late),
              0.1 * heartbeats + 3 + 0.1 * static_cast<double>(late));
  EXPECT_NEAR(static_cast<double>(b.bus->counters().stale - before.stale), static_cast<double>(late + twice),
              0.1 * heartbeats + 3 + 0.1 * static_cast<double>(late));
  EXPECT_GT(invalid, 100);
  EXPECT_EQ(b.reading(0).fault, 0u) << "a few lost frames are no fault";
  EXPECT_EQ(b.bus->strangers(), 0u);
}

TEST(OdriveAxis, SetUpSurvivesABadLine) {
  OdriveBench b(4);
  LineFaults faults;
  faults.corrupt = faults.drop = 0.05;
  b.line->setLineFaults(faults);
  EXPECT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus->problem();
}

}  // namespace
}  // namespace sinew
