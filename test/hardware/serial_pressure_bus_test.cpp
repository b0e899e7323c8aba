#include "sinew/hardware/serial_pressure_bus.h"

#include <gtest/gtest.h>

#include <cmath>

#include "hardware/check_line.h"
#include "hardware/pressure_bench.h"
#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/serial_port.h"

namespace sinew {
namespace {

constexpr double kHysteresis = 150;  // Pa, the simulated boards' 100 and what one update adds

TEST(SerialPressureBus, SetUpArmsEveryBoardAndMovesNothing) {
  PressureBench b(4);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus.problem();
  b.cycles(50);
  double moved = 0;
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(b.boards.energised(i));
    EXPECT_TRUE(b.bus.readings()[static_cast<std::size_t>(i)].zero_valid);
    EXPECT_EQ(b.fault(i), 0u) << b.bus.faultDetail(i);
    moved = std::max(moved, std::abs(b.boards.pressure(i)));
  }
  checkAtMost("pressure_enable_moves", moved, 1, "Pa");
}

TEST(SerialPressureBus, SetUpAgainUnderPressureMovesNothing) {
  PressureBench b(4);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(40000, 150);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus.problem();
  b.cycles(100);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(b.boards.pressure(i), 40000, 2 * kHysteresis) << i;
}

TEST(SerialPressureBus, FollowsSetPointsAndReadsThem) {
  PressureBench b(4);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  for (const double target : {50000., -10000., 20000.}) {
    b.moveTo(target, 300);
    for (int i = 0; i < 4; ++i) {
      const ActuatorReading& r = b.bus.readings()[static_cast<std::size_t>(i)];
      EXPECT_NEAR(b.boards.pressure(i), target, kHysteresis);
      EXPECT_NEAR(r.measured, target, kHysteresis);
      EXPECT_TRUE(r.valid);
      EXPECT_NEAR(r.voltage, 12, 0.01);
      EXPECT_NEAR(r.temperature, 30, 0.1);
    }
  }
  EXPECT_EQ(b.bus.counters().corrupted + b.bus.counters().missing + b.bus.counters().stale, 0u);
}

TEST(SerialPressureBus, TheBoardBoundsRampAndPressureWhateverTheDriverWrites) {
  PressureBench b(2);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.set_points = {1e9, 1e9};
  double last = 0, fastest = 0, highest = 0;
  for (int n = 0; n < 300; ++n) {
    b.cycle();
    const double p = b.boards.pressure(0);
    fastest = std::max(fastest, (p - last) / kPressurePeriod);
    highest = std::max(highest, p);
    last = p;
  }
  checkAtMost("pressure_ramp", fastest, 1.2 * 100000 * 1.1, "Pa/s");
  checkAtMost("pressure_highest", highest, 90000, "Pa");
  EXPECT_GT(highest, 89000);
  b.set_points = {std::nan(""), 1e9};
  b.cycles(10);
  EXPECT_NEAR(b.boards.pressure(0), 90000, 1000) << "what is no number keeps the last set point";
}

TEST(SerialPressureBus, NamesWhatIsWrongWithABoard) {
  PressureBench silent(4);
  silent.boards.setFrozen(2, true);
  EXPECT_EQ(silent.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(silent.bus.problem().find("chamber_3 (board 12) does not answer"), std::string::npos)
      << silent.bus.problem();

  std::vector<PressureActuator> actuators = makePressureActuators(2);
  actuators[1].settings.pressure_limit = 500000;
  PressureBench strong(actuators);
  EXPECT_EQ(strong.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(strong.bus.problem().find("chamber_2 (board 11, channel 2)"), std::string::npos) << strong.bus.problem();
  EXPECT_NE(strong.bus.problem().find("500000 Pa"), std::string::npos) << strong.bus.problem();

  PressureBench stopped(2);
  stopped.boards.setEmergencyStop(true);
  stopped.pass();
  EXPECT_EQ(stopped.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(stopped.bus.problem().find("emergency stop"), std::string::npos) << stopped.bus.problem();
  stopped.boards.setEmergencyStop(false);
  stopped.pass();
  EXPECT_EQ(stopped.setUp(), SetUpProgress::kDone) << stopped.bus.problem();
}

TEST(SerialPressureBus, OtherLimitsUnderPressureAreRefusedInWords) {
  std::vector<PressureActuator> actuators = makePressureActuators(2);
  for (PressureActuator& a : actuators) a.settings.on_silence = PressureMode::kSeal;
  PressureBench b(actuators);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(30000, 100);
  actuators[0].settings.pressure_limit = 85000;
  SerialPressureBus other([&b](std::string&) { return b.line; }, 1000000, makePressureTiming(), actuators);
  std::string why;
  ASSERT_TRUE(other.open(why));
  other.startSetUp(true);
  SetUpProgress progress = SetUpProgress::kBusy;
  for (int n = 0; n < 100 && progress == SetUpProgress::kBusy; ++n) progress = other.updateSetUp(b.line->now());
  EXPECT_EQ(progress, SetUpProgress::kFailed);
  EXPECT_NE(other.problem().find("holds pressure"), std::string::npos) << other.problem();
}

TEST(SerialPressureBus, ALineThatIsTooSlowForItsBoardsIsToldBeforeAnythingMoves) {
  const std::vector<PressureActuator> actuators = makePressureActuators(2);
  PressureBench b(actuators);
  SerialPressureBus slow([&b](std::string&) { return b.line; }, 57600, makePressureTiming(), actuators);
  std::string why;
  ASSERT_TRUE(slow.open(why));
  slow.startSetUp(true);
  SetUpProgress progress = SetUpProgress::kBusy;
  for (int n = 0; n < 100 && progress == SetUpProgress::kBusy; ++n) progress = slow.updateSetUp(b.line->now());
  EXPECT_EQ(progress, SetUpProgress::kFailed);
  // 61 bytes of set points and 47 of state at 5760 bytes a second.
  EXPECT_NE(slow.problem().find("18.8 ms"), std::string::npos) << slow.problem();
  EXPECT_FALSE(b.boards.energised(0));
}

TEST(SerialPressureBus, ASilentMasterIsVentedForWithinTheTimeout) {
  PressureBench b(2);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(50000, 150);
  b.cycle();
  const Time last = b.line->now() - duration(kPressurePeriod);
  while (b.boards.energised(0)) b.pass(1e-3);
  checkAtMost("pressure_silence_vents", seconds(b.line->now() - last), 0.2 + 0.002, "s");
  checkAtLeast("pressure_silence_waits", seconds(b.line->now() - last), 0.2, "s");
  const double before = b.boards.pressure(0);
  b.pass(0.1);
  EXPECT_LT(b.boards.pressure(0), 0.7 * before);
  b.cycles(2);
  EXPECT_NE(b.fault(0) & kFaultWatchdog, 0u);
  b.cycles(200);
  EXPECT_LT(b.boards.pressure(0), 10) << "latched";
}

TEST(SerialPressureBus, WhatWasSealedInSilenceIsTakenOverWithoutMoving) {
  std::vector<PressureActuator> actuators = makePressureActuators(4);
  for (PressureActuator& a : actuators) a.settings.on_silence = PressureMode::kSeal;
  PressureBench b(actuators);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(40000, 150);
  b.pass(3);
  b.cycle();
  EXPECT_NE(b.fault(0) & kFaultWatchdog, 0u);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus.problem();
  b.cycles(100);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(b.boards.pressure(i), 40000, 2 * kHysteresis) << i;
  EXPECT_EQ(b.fault(0), 0u);
}

TEST(SerialPressureBus, ReplayedFramesNeitherMoveNorFeedABoard) {
  PressureBench b(2);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(60000, 150);
  const std::vector<std::uint8_t> old = b.line->lastWritten();
  b.moveTo(20000, 300);
  const auto replay = [&b, &old](int ms) {
    for (int n = 0; n < ms; ++n) {
      b.boards.receive(old.data(), old.size(), b.line->now());
      b.pass(1e-3);
      EXPECT_LT(b.boards.pressure(0), 20000 + kHysteresis);
    }
  };
  replay(150);
  EXPECT_TRUE(b.boards.energised(0));
  replay(100);
  EXPECT_FALSE(b.boards.energised(0)) << "its master has been silent for too long";
  b.cycle();
  EXPECT_GT(b.bus.counters().stale, 100u) << "what it answered to the replays";
}

TEST(SerialPressureBus, SequencesWrapUnnoticed) {
  PressureBench b(1);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  for (int n = 0; n < 70000; ++n) {
    b.bus.writeSetPoints(b.set_points.data(), b.line->now());
    b.bus.read(b.line->now());
  }
  EXPECT_EQ(b.fault(0), 0u) << b.bus.faultDetail(0);
  EXPECT_EQ(b.bus.counters().device_error, 0u);
}

TEST(SerialPressureBus, OnlyReadingFeedsNothing) {
  PressureBench b(2);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(50000, 150);
  for (int n = 0; n < 25; ++n) {
    b.bus.read(b.line->now());
    b.pass();
  }
  EXPECT_FALSE(b.boards.energised(0));
}

TEST(SerialPressureBus, ARestartOfABoardIsLatchedAndStaysVented) {
  PressureBench b(4);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(50000, 150);
  b.boards.powerCycle(2);
  b.cycles(1);
  EXPECT_NE(b.fault(2) & kFaultOff, 0u);
  EXPECT_NE(b.fault(3) & kFaultOff, 0u) << "on the same board";
  EXPECT_EQ(b.fault(0), 0u);
  EXPECT_NE(b.bus.faultDetail(2).find("restarted"), std::string::npos);
  b.cycles(300);
  EXPECT_LT(b.boards.pressure(2), 10);
  EXPECT_NEAR(b.boards.pressure(0), 50000, 2 * kHysteresis);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus.problem();
  b.cycles(10);
  EXPECT_EQ(b.fault(2), 0u);
  EXPECT_LT(b.boards.pressure(2), 2 * kHysteresis) << "set-up alone brings no pressure back";
}

TEST(SerialPressureBus, EveryFaultShowsWithinTheMissingLimit) {
  struct Case {
    const char* name;
    std::uint32_t fault;
    void (*cause)(SimulatedPressureBus&);
  };
  const Case cases[] = {
      {"frozen", kFaultSilent, [](SimulatedPressureBus& s) { s.setFrozen(0, true); }},
      {"hot", kFaultOverheated, [](SimulatedPressureBus& s) { s.setTemperature(0, 90); }},
      {"dip", kFaultVoltage, [](SimulatedPressureBus& s) { s.setSupplyVoltage(9); }},
      {"power", kFaultOff, [](SimulatedPressureBus& s) { s.powerCycle(0); }},
      {"brown-out", kFaultOff,
       [](SimulatedPressureBus& s) {
         s.setSupplyVoltage(3);
         s.setSupplyVoltage(12);
       }},
      {"sensor", kFaultSensor, [](SimulatedPressureBus& s) { s.setSensorBroken(0, true); }},
      {"stop", kFaultDevice, [](SimulatedPressureBus& s) { s.setEmergencyStop(true); }},
  };
  for (const Case& c : cases) {
    PressureBench b(2);
    ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
    b.moveTo(30000, 60);
    c.cause(b.boards);
    b.cycles(makePressureTiming().missing_limit);
    EXPECT_NE(b.fault(0) & c.fault, 0u) << c.name;
    if (c.fault != kFaultSilent) {
      EXPECT_FALSE(b.bus.faultDetail(0).empty()) << c.name;
    }
  }
}

TEST(SerialPressureBus, APumpWithoutPressureShows) {
  PressureBench b(2);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.boards.setPumpBroken(0, true);
  b.boards.setLeak(0, 8);
  b.moveTo(70000, 3000);
  EXPECT_NE(b.fault(0) & kFaultFollowing, 0u);
  EXPECT_NE(b.bus.faultDetail(0).find("pump"), std::string::npos);
}

TEST(SerialPressureBus, RelaxRunsDownToTheAtmosphereAndSwitchOffVents) {
  PressureBench b(3);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(40000, 150);
  const std::vector<bool> which{true, false, true};
  for (int n = 0; n <= 100; ++n) {
    ASSERT_TRUE(b.bus.relax(which, 1 - 0.01 * n));
    if (n > 20) {
      EXPECT_NEAR(b.boards.pressure(0), 40000 * (1 - 0.01 * n), 5000) << n;
    }
    b.pass(0.008);
  }
  EXPECT_LT(b.boards.pressure(0), 4000);
  EXPECT_FALSE(b.boards.energised(0)) << "share 0 vents";
  EXPECT_TRUE(b.boards.energised(1));
  EXPECT_NEAR(b.boards.pressure(1), 40000, 2 * kHysteresis);
  ASSERT_TRUE(b.bus.switchOff({true, true, true}));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(b.boards.energised(i));
  b.cycles(5);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(b.boards.energised(i)) << "set points bring nothing back";
}

TEST(SerialPressureBus, ASilentBoardTakesNothingFromTheOthers) {
  PressureBench b(6);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.moveTo(20000, 60);
  b.boards.setFrozen(0, true);
  for (int n = 0; n < 30; ++n) {
    const Time start = b.line->now();
    b.bus.writeSetPoints(b.set_points.data(), start);
    b.bus.read(start);
    // Three exchanges on the line, 2 ms of a board's turnaround, and the reply timeout once.
    EXPECT_LT(seconds(b.line->now() - start), 0.003 + 0.002 + 3 * 0.0025);
    for (const std::size_t i : {2, 3, 4, 5}) EXPECT_TRUE(b.bus.readings()[i].valid);
    b.pass(1e-3);
  }
  EXPECT_EQ(b.bus.readings()[0].fault, kFaultSilent);
  EXPECT_EQ(b.fault(2) | b.fault(5), 0u);
  EXPECT_NEAR(b.bus.readings()[0].measured, 20000, 2 * kHysteresis) << "the last reading is kept";
}

TEST(SerialPressureBus, ABadLineChangesNothingButCounters) {
  PressureBench b(6);
  LineFaults faults;
  faults.corrupt = faults.drop = faults.delay = faults.duplicate = 0.02;
  faults.seed = 5;
  b.boards.setLineFaults(faults);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus.problem();
  b.moveTo(50000, 2000);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(b.fault(i), 0u) << b.bus.faultDetail(i);
    EXPECT_NEAR(b.boards.pressure(i), 50000, kHysteresis);
  }
  const LineFaultCounts injected = b.boards.lineFaultCounts();
  const BusCounters& seen = b.bus.counters();
  EXPECT_GT(injected.corrupted, 50u);
  EXPECT_GE(seen.corrupted, injected.corrupted);
  EXPECT_LE(seen.corrupted, 2 * injected.corrupted) << "a zero in the middle makes two damaged frames of one";
  EXPECT_NEAR(static_cast<double>(seen.missing), static_cast<double>(injected.dropped + injected.delayed), 15);
  EXPECT_EQ(seen.stale, injected.delayed + injected.duplicated);
}

TEST(SerialPressureBus, AnUnpluggedLineIsToldAndReopened) {
  PressureBench b(2);
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.line->setPlugged(false);
  EXPECT_FALSE(b.cycle());
  b.bus.close();
  EXPECT_FALSE(b.bus.isOpen());
  EXPECT_FALSE(b.bus.read(b.line->now()));
  b.line->setPlugged(true);
  std::string why;
  EXPECT_TRUE(b.bus.open(why));
  b.pass(0.3);
  EXPECT_EQ(b.setUp(), SetUpProgress::kDone) << b.bus.problem();
}

TEST(SerialPressureBus, WorksOverAPseudoTerminal) {
  const std::vector<PressureActuator> actuators = makePressureActuators(4);
  PseudoTerminal terminal;
  SimulatedPressureBus boards(placesOf(actuators));
  boards.start(terminal);
  DeviceTiming timing = makePressureTiming();
  timing.reply_timeout = 1;
  SerialPressureBus bus(
      [&terminal](std::string& why) -> std::shared_ptr<ByteStream> {
        auto port = std::make_shared<SerialPort>();
        if (port->open(terminal.path(), 1000000)) return port;
        why = port->error();
        return nullptr;
      },
      1000000, timing, actuators);
  std::string why;
  ASSERT_TRUE(bus.open(why)) << why;
  bus.startSetUp(true);
  SetUpProgress progress = SetUpProgress::kBusy;
  for (int n = 0; n < 100 && progress == SetUpProgress::kBusy; ++n) progress = bus.updateSetUp(Clock::now());
  EXPECT_EQ(progress, SetUpProgress::kDone) << bus.problem();
  bus.close();
  boards.stop();
}

}  // namespace
}  // namespace sinew
