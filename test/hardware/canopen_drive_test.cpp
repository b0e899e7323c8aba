#include "sinew/hardware/canopen_drive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "hardware/canopen_rig.h"
#include "sinew/common/config_error.h"
#include "sinew/hardware/can_device_bus.h"
#include "sinew/hardware/simulated_can_bus.h"
#include "sinew/hardware/simulated_can_port.h"
#include "sinew/hardware/simulated_cia402_drive.h"
#include "solver/allocation_count.h"

namespace sinew {
namespace {

using Rig = CanopenRig;
constexpr double kPeriod = Rig::kPeriod, kWatchdog = Rig::kWatchdog, kRadius = Rig::kRadius;
constexpr double kCount = kRadius / Rig::kCountsPerRadian;  // m of cable

class CanopenDriveTest : public testing::Test {
 protected:
  void make(const CanopenSettings& settings = Rig::makeSettings(), const WinchDescription& cable = Rig::makeCable(),
            const SimulatedCia402Drive::Parameters& parameters = {}) {
    rig = std::make_unique<Rig>(settings, cable, parameters);
  }
  void setUpWell(bool home_all = false) {
    ASSERT_EQ(rig->setUp(home_all), SetUpProgress::kDone) << rig->drive.problem();
  }
  void SetUp() override { make(); }

  std::unique_ptr<Rig> rig;
};

// --- Set-up ---

TEST_F(CanopenDriveTest, SetUpMovesNothing) {
  for (const double angle : {0., 1., -20.}) {
    for (const double load : {0., 0.015, -0.015}) {
      make();
      rig->node.setShaftAngle(angle);
      rig->node.setLoadTorque(0, load);
      rig->node.setObject(0x607A, 0, 123456);  // a stale target
      rig->node.setObject(0x6060, 0, 8);
      rig->node.setObject(0x6061, 0, 8);
      setUpWell();
      EXPECT_TRUE(rig->node.energised(0));
      EXPECT_FALSE(rig->reading().zero_valid);
      rig->cycles(50, rig->reading().measured);
      EXPECT_NEAR(rig->node.shaftAngle(0), angle, 0.51 / Rig::kCountsPerRadian);
      EXPECT_EQ(rig->reading().fault, 0u);
    }
  }
}

TEST_F(CanopenDriveTest, RecoveryUnderLoadMovesNothing) {
  setUpWell();
  rig->drive.setZero(0, 0);
  rig->cycles(100, 0.02);
  rig->node.setLoadTorque(0, -0.15);  // three quarters of what it may pull
  rig->cycles(50, 0.02);
  const double before = rig->node.shaftAngle(0);
  setUpWell();  // from operation
  rig->cycles(20, rig->reading().measured);
  EXPECT_NEAR(rig->node.shaftAngle(0), before, 1 / Rig::kCountsPerRadian);
  rig->bench.pass(0.5);  // the driver sleeps
  EXPECT_EQ(rig->node.statusword() & 0x6F, 0x07);
  setUpWell();  // from quick stop
  rig->cycles(20, rig->reading().measured);
  EXPECT_NEAR(rig->node.shaftAngle(0), before, 2 / Rig::kCountsPerRadian);
  EXPECT_TRUE(rig->reading().zero_valid);
  EXPECT_NEAR(rig->reading().measured, 0.02, 3 * kCount);
}

// Somebody else has switched it on in profile position mode, with a target that means nothing there.
TEST_F(CanopenDriveTest, SetUpOfADriveThatIsOnInAnotherModeMovesNothing) {
  const auto control = [&](std::uint8_t word) {
    CanFrame frame;
    frame.id = 0x605;
    frame.size = 8;
    frame.data = {0x2B, 0x40, 0x60, 0x00, word};
    rig->bench.send(frame);
  };
  rig->node.setObject(0x6065, 0, 0xFFFFFFFF);
  rig->node.setObject(0x607A, 0, 20000);
  for (const int word : {0x06, 0x07, 0x0F}) control(static_cast<std::uint8_t>(word));
  ASSERT_TRUE(rig->node.energised(0));
  rig->bench.pass(0.1);
  setUpWell();
  rig->cycles(20, rig->reading().measured);
  EXPECT_NEAR(rig->node.shaftAngle(0), 0, 1e-9);
}

// A limp shaft that a load drags along: it is caught where it is by then, give or take three cycles of questions.
TEST_F(CanopenDriveTest, CatchesAShaftThatDrifts) {
  constexpr double kDrift = 0.5;  // rad/s: 0.005 N m beyond the gear's friction
  rig->node.setLoadTorque(0, -0.025);
  rig->drive.startSetUp(false);
  SetUpProgress progress = SetUpProgress::kBusy;
  double farthest = 0;
  while (progress == SetUpProgress::kBusy) {
    rig->bench.deliver();
    progress = rig->drive.updateSetUp(rig->bench.now(), rig->bench);
    rig->bench.pass(kPeriod);
    farthest = std::min(farthest, rig->node.shaftAngle(0));
  }
  ASSERT_EQ(progress, SetUpProgress::kDone) << rig->drive.problem();
  rig->cycles(20, rig->reading().measured);
  EXPECT_LT(farthest, -0.1);
  EXPECT_LT(rig->node.shaftAngle(0) - farthest, 3.5 * kDrift * kPeriod);
}

TEST_F(CanopenDriveTest, SetUpSurvivesABadLine) {
  LineFaults faults;
  faults.drop = faults.delay = faults.duplicate = faults.corrupt = 0.05;
  int done = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    make();
    faults.seed = seed;
    rig->bench.setLineFaults(faults);
    rig->node.setShaftAngle(1);
    done += rig->setUp() == SetUpProgress::kDone ? 1 : 0;
    EXPECT_NEAR(rig->node.shaftAngle(0), 1, 0.51 / Rig::kCountsPerRadian);
  }
  EXPECT_EQ(done, 20);
}

TEST_F(CanopenDriveTest, ASilentDriveFailsTheSetUpByName) {
  rig->node.setFrozen(true);
  EXPECT_EQ(rig->setUp(), SetUpProgress::kFailed);
  EXPECT_NE(rig->drive.problem().find("cable (node 5) does not answer"), std::string::npos) << rig->drive.problem();
  rig->node.setFrozen(false);
  setUpWell();
}

TEST_F(CanopenDriveTest, ADriveWhoseFaultRemainsFailsTheSetUpInItsOwnWords) {
  rig->node.setTemperature(150);
  EXPECT_EQ(rig->setUp(), SetUpProgress::kFailed);
  EXPECT_NE(rig->drive.problem().find("state is: fault"), std::string::npos) << rig->drive.problem();
  EXPECT_NE(rig->drive.problem().find("0x4210"), std::string::npos) << rig->drive.problem();
  EXPECT_FALSE(rig->node.energised(0));
}

TEST_F(CanopenDriveTest, RefusesWhatDoesNotFit) {
  WinchDescription cable = Rig::makeCable();
  cable.homing.method = HomingMethod::kDevice;
  EXPECT_THROW(make(Rig::makeSettings(), cable), ConfigError);
  CanopenSettings settings = Rig::makeSettings();
  settings.counts_per_turn = 1e9;
  EXPECT_THROW(make(settings), ConfigError);
}

// --- Motion ---

// Ramp of 0.1 m/s: the demand is where the set point was a period ago, the shaft its response time behind.
TEST_F(CanopenDriveTest, FollowsARampWithinTheInterpolationDelay) {
  for (const int sign : {1, -1}) {
    make(Rig::makeSettings(), Rig::makeCable(sign));
    setUpWell();
    constexpr double kSpeed = 0.1, kDelay = kPeriod + 0.005 + 0.001;
    double worst = 0;
    for (int i = 0; i < 80; ++i) {
      const double set_point = kSpeed * kPeriod * i;
      rig->cycle(set_point);
      ASSERT_TRUE(rig->reading().valid);
      worst = std::max(worst, std::abs(rig->reading().measured - set_point));
      EXPECT_NEAR(rig->reading().measured, static_cast<double>(rig->node.object(0x6064)) * sign * kCount,
                  0.3 * kSpeed * kPeriod + kCount);
    }
    EXPECT_LT(worst, kSpeed * kDelay + 2 * kCount);
    EXPECT_GT(worst, kSpeed * kPeriod * 0.9);
    rig->cycles(20, 0.0799);
    EXPECT_NEAR(rig->reading().measured, 0.0799, 2 * kCount);
    EXPECT_NEAR(rig->node.shaftAngle(0), sign * 0.0799 / kRadius, 2 / Rig::kCountsPerRadian);
    EXPECT_EQ(rig->reading().fault, 0u);
  }
}

// Each cycle's reading is that cycle's, also after answers came late.
TEST_F(CanopenDriveTest, LateAnswersDoNotMakeTheReadingsLag) {
  setUpWell();
  LineFaults faults;
  faults.delay = 0.3;
  faults.delay_time = 0.015;
  rig->bench.setLineFaults(faults);
  for (int i = 0; i < 40; ++i) rig->cycle(1e-3 * i);
  rig->bench.setLineFaults({});
  rig->cycles(3, 0.04);
  double position = 0;
  for (int i = 0; i < 20; ++i) {
    position = rig->node.shaftAngle(0) * kRadius;
    rig->cycle(0.04 - 2e-3 * i);
    ASSERT_TRUE(rig->reading().valid);
    EXPECT_NEAR(rig->reading().measured, position, 1.3e-3);  // at most 0.5 ms of a set point's move later
  }
  EXPECT_GT(rig->drive.counters().stale, 0u);
}

TEST_F(CanopenDriveTest, TheDriveBoundsTheTension) {
  setUpWell();
  EXPECT_EQ(rig->node.object(0x6072), 200);  // 20 N 0.01 m of 10 times 0.1 N m rated
  rig->node.setLoadTorque(0, -1);            // 100 N
  for (int i = 0; i < 5; ++i) {
    rig->cycle(0);
    EXPECT_LE(rig->node.motorTorque(), Rig::kTensionMax * kRadius + 1e-9);
  }
  EXPECT_NEAR(rig->reading().effort, Rig::kTensionMax, 1e-6);
  EXPECT_NEAR(rig->reading().current, 0.4, 1e-6);  // 0.2 N m by 0.5 N m/A
  EXPECT_LT(rig->node.shaftAngle(0), -1);
}

TEST_F(CanopenDriveTest, EveryWayToBoundTheEffort) {
  for (const CanopenEffort effort : {CanopenEffort::kTorque, CanopenEffort::kCurrent, CanopenEffort::kEpos4Current}) {
    CanopenSettings settings = Rig::makeSettings();
    settings.effort = effort;
    make(settings, Rig::makeCable(-1));
    setUpWell();
    rig->node.setLoadTorque(0, 0.3);
    rig->cycles(3, 0);
    EXPECT_NEAR(rig->node.motorTorque(), -0.2, 1e-3) << static_cast<int>(effort);
    EXPECT_NEAR(rig->reading().effort, 20, 0.1) << static_cast<int>(effort);
    EXPECT_NEAR(rig->reading().current, 0.4, 0.002) << static_cast<int>(effort);
  }
}

TEST_F(CanopenDriveTest, RelaxesAndLetsGo) {
  setUpWell();
  rig->node.setLoadTorque(0, -0.1);  // 10 N
  rig->cycles(10, 0);
  const bool which[] = {true};
  for (int i = 0; i <= 20; ++i) {
    const double share = 1 - i / 20.;
    rig->drive.relax(which, share, rig->bench);
    rig->bench.pass(kPeriod);
    EXPECT_LE(rig->node.motorTorque(), share * 0.1 + 1e-3);
    EXPECT_TRUE(rig->node.energised(0)) << "it is still spoken to";
  }
  rig->drive.switchOff(which, rig->bench);
  EXPECT_FALSE(rig->node.energised(0));
  rig->cycles(10, 0);
  EXPECT_FALSE(rig->node.energised(0)) << "until the next set-up";
  EXPECT_EQ(rig->reading().fault, 0u);
  setUpWell();
  EXPECT_TRUE(rig->node.energised(0));
  EXPECT_EQ(rig->node.object(0x6072), 200);
}

TEST_F(CanopenDriveTest, ASetPointThatIsNoNumberChangesNothing) {
  setUpWell();
  rig->cycles(50, 0.01);
  rig->cycles(20, std::numeric_limits<double>::quiet_NaN());
  rig->cycles(20, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(rig->node.shaftAngle(0) * kRadius, 0.01, 2 * kCount);
}

TEST_F(CanopenDriveTest, TheCycleDoesNotAllocate) {
  struct Sink : CanSender {
    bool send(const CanFrame&) override { return true; }
  } sink;
  setUpWell();
  CanFrame first, second, emergency, heartbeat;
  first.id = 0x185;
  first.size = 6;
  first.data = {0x37, 0x12};
  second.id = 0x285;
  second.size = 2;
  emergency.id = 0x085;
  emergency.size = 8;
  emergency.data = {0x11, 0x86, 0x20};
  heartbeat.id = 0x705;
  heartbeat.size = 1;
  heartbeat.data = {0x05};
  const bool which[] = {true};
  const double set_point = 0.001;
  Time now = rig->bench.now();
  const long before = allocationCount();
  for (int i = 0; i < 100; ++i) {
    now += duration(kPeriod);
    rig->drive.writeSetPoints(&set_point, now, sink);
    rig->drive.request(now, sink);
    for (const CanFrame& frame : {first, second, heartbeat}) rig->drive.take(frame, now);
    if (i > 50) rig->drive.take(emergency, now);
    rig->drive.endCycle(now);
    if (i > 90) rig->drive.relax(which, 0.5, sink);
  }
  rig->drive.switchOff(which, sink);
  EXPECT_EQ(allocationCount(), before);
}

// --- Supervision ---

TEST_F(CanopenDriveTest, TheDriveStopsWhenTheDriverFallsSilent) {
  setUpWell();
  for (int i = 0; i < 20; ++i) rig->cycle(1e-3 * i);
  double waited = 0;
  for (; (rig->node.statusword() & 0x6F) != 0x07 && waited < 1; waited += 1e-3) rig->bench.pass(1e-3);
  EXPECT_LE(waited, kWatchdog + 2e-3);
  EXPECT_GT(waited, kWatchdog / 2);
  rig->bench.pass(0.1);
  const double stopped = rig->node.shaftAngle(0);
  rig->cycles(50, 0.05);  // it comes back, with a target far away
  EXPECT_NE(rig->reading().fault & kFaultWatchdog, 0u);
  EXPECT_NEAR(rig->node.shaftAngle(0), stopped, 1e-9) << "latched";
  setUpWell();
  EXPECT_NEAR(rig->node.shaftAngle(0), stopped, 1 / Rig::kCountsPerRadian);
  rig->cycles(100, rig->reading().measured + 0.01);
  EXPECT_NEAR(rig->node.shaftAngle(0), stopped + 1, 1e-3);
}

// Only its heartbeats were lost: the drive has stopped, and says so before its next statusword could.
TEST_F(CanopenDriveTest, AnEmergencyOfSupervisionStopsTheDriveForGood) {
  setUpWell();
  rig->cycles(10, 0.01);
  CanFrame emergency;
  emergency.id = 0x085;
  emergency.size = 8;
  emergency.data = {0x30, 0x81, 0x11};
  rig->drive.take(emergency, rig->bench.now());
  rig->bench.forget();
  rig->cycles(5, 0.05);
  EXPECT_NE(rig->reading().fault & kFaultWatchdog, 0u);
  EXPECT_EQ(rig->node.statusword() & 0x6F, 0x07);
  for (const CanFrame& f : rig->bench.sent()) EXPECT_EQ(f.data[0], f.id == 0x205 ? 0x02 : f.data[0]);
}

TEST_F(CanopenDriveTest, LetsGoOnSilenceIfToldTo) {
  CanopenSettings settings = Rig::makeSettings();
  settings.hold_on_silence = false;
  make(settings);
  setUpWell();
  rig->cycles(10, 0);
  rig->bench.pass(0.5);
  EXPECT_FALSE(rig->node.energised(0));
}

TEST_F(CanopenDriveTest, HeartbeatsLeaveRoomForLostOnes) {
  setUpWell();
  rig->bench.forget();
  rig->cycles(100, 0);
  int heartbeats = 0, syncs = 0;
  for (const CanFrame& f : rig->bench.sent()) {
    heartbeats += f.id == 0x77F ? 1 : 0;
    syncs += f.id == 0x080 ? 1 : 0;
  }
  EXPECT_EQ(syncs, 100);
  EXPECT_GE(heartbeats, 33);  // at least every third of the watchdog's time
  EXPECT_LE(heartbeats, 50);
}

// --- Faults: each shown within missing_limit cycles, latched, gone by a set-up ---

TEST_F(CanopenDriveTest, ShowsEveryFault) {
  struct Case {
    const char* what;
    std::uint32_t fault;
    bool zero_valid;
    void (*begin)(Rig&);
    void (*end)(Rig&);
  };
  const Case kCases[] = {
      {"freeze", kFaultSilent, true, [](Rig& r) { r.node.setFrozen(true); }, [](Rig& r) { r.node.setFrozen(false); }},
      {"cut", kFaultSilent, true, [](Rig& r) { r.bench.setCut(true); }, [](Rig& r) { r.bench.setCut(false); }},
      {"drop", kFaultSilent, true,
       [](Rig& r) {
         LineFaults faults;
         faults.drop = 1;
         r.bench.setLineFaults(faults);
       },
       [](Rig& r) { r.bench.setLineFaults({}); }},
      {"delay", kFaultSilent, true,
       [](Rig& r) {
         LineFaults faults;
         faults.delay = 1;
         r.bench.setLineFaults(faults);
       },
       [](Rig& r) { r.bench.setLineFaults({}); }},
      {"overheat", kFaultOverheated, true, [](Rig& r) { r.node.setTemperature(150); },
       [](Rig& r) { r.node.setTemperature(30); }},
      {"dip", kFaultUndervolted, false, [](Rig& r) { r.node.setSupplyVoltage(12); },
       [](Rig& r) { r.node.setSupplyVoltage(24); }},
      {"supply too high", kFaultVoltage, true, [](Rig& r) { r.node.setSupplyVoltage(60); },
       [](Rig& r) { r.node.setSupplyVoltage(24); }},
      {"brown-out", kFaultOff, false,
       [](Rig& r) {
         r.node.setSupplyVoltage(2);
         r.bench.pass(0.02);
         r.node.setSupplyVoltage(24);
       },
       [](Rig&) {}},
      {"power cycle", kFaultOff, false, [](Rig& r) { r.node.powerCycle(); }, [](Rig&) {}},
      {"jump", kFaultJumped, false, [](Rig& r) { r.node.setShaftAngle(r.node.shaftAngle(0) + 3); }, [](Rig&) {}},
  };
  for (const Case& c : kCases) {
    make();
    setUpWell();
    rig->drive.setZero(0, 0);
    rig->cycles(20, 0.01);
    ASSERT_TRUE(rig->reading().zero_valid);
    c.begin(*rig);
    const int cycles = rig->cyclesUntil(c.fault);
    EXPECT_GE(cycles, 1) << c.what;
    EXPECT_LE(cycles, Rig::kMissingLimit) << c.what;
    rig->cycles(30, 0.01);
    EXPECT_EQ(rig->reading().zero_valid, c.zero_valid) << c.what;
    c.end(*rig);
    rig->cycles(30, 0.01);
    EXPECT_NE(rig->reading().fault & c.fault, 0u) << c.what << " is latched";
    const double before = rig->node.shaftAngle(0);
    setUpWell();
    EXPECT_EQ(rig->reading().fault, 0u) << c.what;
    rig->cycles(20, rig->reading().measured);
    EXPECT_NEAR(rig->node.shaftAngle(0), before, 1 / Rig::kCountsPerRadian) << c.what;
    EXPECT_EQ(rig->reading().fault, 0u) << c.what;
    EXPECT_EQ(rig->reading().zero_valid, c.zero_valid) << c.what;
    EXPECT_TRUE(rig->node.energised(0)) << c.what;
  }
}

TEST_F(CanopenDriveTest, DoubledFramesChangeNothing) {
  setUpWell();
  LineFaults faults;
  faults.duplicate = 1;
  rig->bench.setLineFaults(faults);
  rig->cycles(100, 0.01);
  EXPECT_EQ(rig->reading().fault, 0u);
  EXPECT_TRUE(rig->reading().valid);
  EXPECT_NEAR(rig->reading().measured, 0.01, 2 * kCount);
}

TEST_F(CanopenDriveTest, AFewLostFramesAreNoFault) {
  setUpWell();
  LineFaults faults;
  faults.drop = faults.delay = 0.05;
  rig->bench.setLineFaults(faults);
  int missing = 0;
  for (int i = 0; i < 1000; ++i) {
    rig->cycle(0.02 * std::sin(0.01 * i));
    missing += rig->reading().valid ? 0 : 1;
  }
  EXPECT_EQ(rig->reading().fault, 0u);
  EXPECT_NEAR(missing, 190, 60);  // one in ten, two frames a cycle
  EXPECT_EQ(rig->drive.counters().missing, static_cast<std::uint64_t>(missing));
}

TEST_F(CanopenDriveTest, AsksForTheCodeWhenTheEmergencyWasLost) {
  setUpWell();
  rig->cycles(10, 0);
  LineFaults faults;
  faults.drop = 1;
  rig->bench.setLineFaults(faults);
  rig->node.setTemperature(150);
  rig->bench.pass(2e-3);  // the emergency goes, and is lost
  rig->bench.setLineFaults({});
  EXPECT_LE(rig->cyclesUntil(kFaultDevice), 2);
  EXPECT_LE(rig->cyclesUntil(kFaultOverheated), Rig::kMissingLimit);
  EXPECT_NE(rig->drive.faultDetail(0).find("0x4210 (the electronics are too hot)"), std::string::npos)
      << rig->drive.faultDetail(0);
}

TEST_F(CanopenDriveTest, TellsInWordsWhatTheDriveSays) {
  setUpWell();
  EXPECT_EQ(rig->drive.faultDetail(0), "");
  rig->node.setTemperature(150);
  rig->cycles(3, 0);
  EXPECT_EQ(rig->drive.faultDetail(0),
            "error code 0x4210 (the electronics are too hot), error register 0x09, state fault");
  EXPECT_EQ(rig->drive.counters().device_error, 1u);
}

TEST_F(CanopenDriveTest, FollowingErrorsAreFaults) {
  CanopenSettings settings = Rig::makeSettings();
  settings.following_window = 0.005;
  make(settings);
  setUpWell();
  EXPECT_EQ(rig->node.object(0x6065), static_cast<std::int64_t>(std::ceil(0.005 / kCount)));
  rig->node.setLoadTorque(0, -1);
  EXPECT_LE(rig->cyclesUntil(kFaultFollowing), 3);
  EXPECT_FALSE(rig->cyclesUntil(kFaultVoltage, 100) > 0);
}

TEST_F(CanopenDriveTest, ALimitThatLastsIsOverload) {
  CanopenSettings settings = Rig::makeSettings();
  settings.limit_time = 0.1;
  make(settings);
  setUpWell();
  rig->node.setLoadTorque(0, -0.21);
  rig->cycles(8, 0);
  EXPECT_EQ(rig->reading().fault, 0u);
  rig->cycles(5, 0);
  EXPECT_EQ(rig->reading().fault, kFaultOverload);
}

TEST_F(CanopenDriveTest, AnAbsoluteEncoderKeepsItsZero) {
  CanopenSettings settings = Rig::makeSettings();
  settings.absolute_encoder = true;
  SimulatedCia402Drive::Parameters parameters;
  parameters.absolute_encoder = true;
  make(settings, Rig::makeCable(), parameters);
  rig->node.setShaftAngle(2);
  setUpWell();
  EXPECT_FALSE(rig->reading().zero_valid) << "nobody has named it yet";
  rig->drive.setZero(0, 0.01);
  rig->cycles(50, 0.02);
  rig->node.powerCycle();
  EXPECT_LE(rig->cyclesUntil(kFaultOff), Rig::kMissingLimit);
  setUpWell();
  EXPECT_TRUE(rig->reading().zero_valid);
  EXPECT_NEAR(rig->reading().measured, 0.02, 2 * kCount);
}

// The boot-up message is lost, and the drive is back before anyone misses it: the trace that set-up leaves is gone.
TEST_F(CanopenDriveTest, ARestartThatNobodySawLosesTheZero) {
  setUpWell();
  rig->drive.setZero(0, 0);
  rig->cycles(20, 0.01);
  LineFaults faults;
  faults.drop = 1;
  rig->bench.setLineFaults(faults);
  rig->node.powerCycle();
  rig->bench.pass(0.01);
  rig->bench.setLineFaults({});
  setUpWell();
  EXPECT_FALSE(rig->reading().zero_valid);
}

TEST_F(CanopenDriveTest, ZerosAreKeptUnlessAllAreToBeHomed) {
  setUpWell();
  rig->drive.setZero(0, 0.03);
  setUpWell();
  EXPECT_TRUE(rig->reading().zero_valid);
  EXPECT_NEAR(rig->reading().measured, 0.03, kCount);
  setUpWell(true);
  EXPECT_FALSE(rig->reading().zero_valid);
}

// --- Homing by the drive ---

class HomingDrive : public CanopenDriveTest {
 protected:
  void SetUp() override {
    settings.homing.method = 17;
    settings.homing.search_speed = 2;
    settings.homing.zero_speed = 0.2;
    settings.homing.acceleration = 20;
    settings.homing.timeout = 10;
    cable.homing.method = HomingMethod::kDevice;
    parameters.lower_switch = -1.5;
    make(settings, cable, parameters);
  }
  CanopenSettings settings = Rig::makeSettings();
  WinchDescription cable = Rig::makeCable();
  SimulatedCia402Drive::Parameters parameters;
};

TEST_F(HomingDrive, ItsZeroIsWhereItEnds) {
  setUpWell();
  EXPECT_TRUE(rig->reading().zero_valid);
  EXPECT_NEAR(rig->reading().measured, 0, 1e-9);
  EXPECT_NEAR(rig->node.shaftAngle(0), -1.5, 2e-3);
  rig->cycles(100, 0.01);
  EXPECT_NEAR(rig->node.shaftAngle(0), -0.5, 3e-3);
  EXPECT_EQ(rig->reading().fault, 0u);
  setUpWell();  // it is known now
  EXPECT_NEAR(rig->node.shaftAngle(0), -0.5, 3e-3);
  setUpWell(true);
  EXPECT_NEAR(rig->node.shaftAngle(0), -1.5, 2e-3);
}

TEST_F(HomingDrive, RestartedDrivesHomeAgain) {
  setUpWell();
  rig->cycles(100, 0.01);
  rig->node.powerCycle();
  rig->cycles(10, 0.01);
  setUpWell();
  EXPECT_TRUE(rig->reading().zero_valid);
  EXPECT_NEAR(rig->node.shaftAngle(0), -1.5, 2e-3);
}

TEST_F(HomingDrive, ASwitchThatNeverClosesFailsAndStops) {
  parameters.lower_switch = -1e9;
  settings.homing.timeout = 1;
  make(settings, cable, parameters);
  EXPECT_EQ(rig->setUp(), SetUpProgress::kFailed);
  EXPECT_NE(rig->drive.problem().find("zero"), std::string::npos) << rig->drive.problem();
  rig->bench.pass(0.5);
  const double stopped = rig->node.shaftAngle(0);
  rig->bench.pass(0.5);
  EXPECT_NEAR(rig->node.shaftAngle(0), stopped, 1e-9);
  EXPECT_FALSE(rig->reading().zero_valid);
}

// --- Several drives on one bus ---

TEST(CanopenDrives, ShareABus) {
  constexpr std::uint8_t kCountOfDrives = 6;
  CanopenBench bench(kPeriod);
  std::vector<std::unique_ptr<SimulatedCia402Drive>> nodes;
  std::vector<std::unique_ptr<CanopenDrive>> drives;
  for (std::uint8_t n = 1; n <= kCountOfDrives; ++n) {
    nodes.push_back(std::make_unique<SimulatedCia402Drive>(n, SimulatedCia402Drive::Parameters{}));
    drives.push_back(std::make_unique<CanopenDrive>(Rig::makeSettings(n), Rig::makeCable(n % 2 == 0 ? 1 : -1),
                                                    Rig::makeBounds(), Rig::makeTiming()));
    bench.add(*nodes.back());
    bench.add(*drives.back());
  }
  for (auto& d : drives) d->startSetUp(false);
  std::vector<bool> done(drives.size(), false);
  for (int i = 0; i < 500; ++i) {
    bench.deliver();
    const double hold = 0;
    for (std::size_t d = 0; d < drives.size(); ++d) {
      if (done[d])
        drives[d]->writeSetPoints(&hold, bench.now(), bench);
      else
        done[d] = drives[d]->updateSetUp(bench.now(), bench) == SetUpProgress::kDone;
      ASSERT_EQ(drives[d]->problem(), "");
    }
    bench.send(CanopenBench::makeSync());
    bench.pass(kPeriod);
  }
  std::vector<double> set_points;
  for (std::size_t d = 0; d < drives.size(); ++d) {
    EXPECT_TRUE(done[d]);
    set_points.push_back(0.005 * static_cast<double>(d));
  }
  for (int i = 0; i < 100; ++i) bench.cycle(set_points);
  nodes[2]->setFrozen(true);
  for (int i = 0; i < 10; ++i) bench.cycle(set_points);
  for (std::size_t d = 0; d < drives.size(); ++d) {
    EXPECT_EQ(drives[d]->readings()[0].fault, d == 2 ? kFaultSilent : 0u) << d;
    EXPECT_NEAR(drives[d]->readings()[0].measured, set_points[d], 2 * kCount) << d;
    EXPECT_EQ(drives[d]->counters().corrupted, 0u);
  }
}

// The same through the bus that the driver uses, with frames that take their time and wait for each other.
TEST(CanopenDrives, OnABusThatTakesItsTime) {
  constexpr int kDrives = 3;
  std::vector<SimulatedCanBus::Member> simulated;
  std::vector<CanDeviceBus::Member> members;
  for (int i = 0; i < kDrives; ++i) {
    const auto node = static_cast<std::uint8_t>(10 + i);
    simulated.push_back({std::make_unique<SimulatedCia402Drive>(node, SimulatedCia402Drive::Parameters{}), {i}});
    members.push_back({std::make_unique<CanopenDrive>(Rig::makeSettings(node), Rig::makeCable(), Rig::makeBounds(),
                                                      Rig::makeTiming()),
                       {i}});
  }
  SimulatedCanBus line(std::move(simulated), 500000);
  const auto port = std::make_shared<SimulatedCanPort>(line);
  CanDeviceBus bus([&](std::string&) { return port; }, std::move(members), Rig::makeTiming());
  std::string why;
  ASSERT_TRUE(bus.open(why));
  Time next = port->now();
  const auto pass = [&] {
    line.step(kPeriod);
    next += duration(kPeriod);
    port->advanceTo(next);
  };
  bus.startSetUp(false);
  SetUpProgress progress = SetUpProgress::kBusy;
  for (int i = 0; i < 500 && progress == SetUpProgress::kBusy; ++i, pass()) progress = bus.updateSetUp(port->now());
  ASSERT_EQ(progress, SetUpProgress::kDone) << bus.problem();
  for (int i = 0; i < kDrives; ++i) EXPECT_EQ(line.shaftAngle(i), 0);
  const double set_points[kDrives] = {0.01, -0.01, 0.02};
  for (int n = 0; n < 100; ++n, pass()) {
    ASSERT_TRUE(bus.writeSetPoints(set_points, port->now()) && bus.read(port->now()));
    for (int i = 0; i < kDrives; ++i) ASSERT_TRUE(bus.readings()[static_cast<std::size_t>(i)].valid) << n;
  }
  for (int i = 0; i < kDrives; ++i) {
    EXPECT_NEAR(line.shaftAngle(i), set_points[i] / kRadius, 2 / Rig::kCountsPerRadian);
    EXPECT_EQ(bus.readings()[static_cast<std::size_t>(i)].fault, 0u);
  }
  for (int n = 0; n < 50; ++n) pass();  // the driver is gone
  line.setFrozen(1, true);
  for (int n = 0; n < 10; ++n, pass()) bus.writeSetPoints(set_points, port->now()), bus.read(port->now());
  EXPECT_NE(bus.readings()[0].fault & kFaultWatchdog, 0u);
  EXPECT_NE(bus.readings()[1].fault & kFaultSilent, 0u);
}

}  // namespace
}  // namespace sinew
