#include <gtest/gtest.h>

#include "firmware/board_bench.h"

namespace sinew {
namespace {

struct ArmedBench : BoardBench {
  ArmedBench() {
    const sinew_configuration c = makeConfiguration();
    EXPECT_EQ(sinew_board_configure(&board, &c), SINEW_ACCEPTED);
  }
};

TEST(SinewBoard, BootsVentedAndRefusesToRegulateUnarmed) {
  BoardBench b;
  for (const auto& c : b.chambers) {
    EXPECT_EQ(c.path, SINEW_PATH_EXHAUST);
    EXPECT_EQ(c.duty, 255);
  }
  EXPECT_EQ(b.command(BoardBench::regulate(1000)), SINEW_NOT_ARMED);
  EXPECT_EQ(b.command({SINEW_SEAL, 0, 0, 1}), SINEW_NOT_ARMED);
  EXPECT_EQ(b.command({SINEW_VENT, 0, 0, 0}), SINEW_ACCEPTED);
  b.pass(50);
  EXPECT_EQ(b.mode(0), SINEW_VENT);
}

TEST(SinewBoard, ReachesItsSetPointWithinTheHysteresis) {
  ArmedBench b;
  for (const int target : {40000, 90000, 10000, -20000, 5000}) {
    b.hold(BoardBench::regulate(target), 2000);
    EXPECT_NEAR(b.chambers[0].pressure, target, 450) << target;
    EXPECT_EQ(b.chambers[0].path, SINEW_PATH_CLOSED) << "at rest";
    EXPECT_EQ(b.faults(0), 0);
  }
}

TEST(SinewBoard, PressureFollowsNoFasterThanTheRamp) {
  ArmedBench b;
  for (const std::uint32_t ramp : {5000u, 50000u, 200000u, 4000000u}) {
    const double allowed = std::min(ramp, 200000u);  // the configuration's own ramp bounds it
    const double start = b.chambers[0].pressure;
    for (int n = 0; n < 30; ++n) {
      b.command(BoardBench::regulate(90000, ramp));
      for (int ms = 0; ms < 10; ++ms) {
        b.pass(1);
        const double elapsed = 1e-3 * (10 * n + ms + 1);
        EXPECT_LE(b.chambers[0].pressure, start + allowed * elapsed + 1);
      }
    }
    EXPECT_GT(b.chambers[0].pressure, start + std::min(0.25 * allowed, 60000.) - 3000);
    b.hold(BoardBench::regulate(0), 1500);
  }
}

TEST(SinewBoard, SmallRampsAddUpOverManyUpdates) {
  ArmedBench b;
  b.hold(BoardBench::regulate(20000, 700), 10000);  // 0.7 Pa a millisecond
  EXPECT_NEAR(b.board.channels[0].reference, 7000, 2);
}

TEST(SinewBoard, NeverPassesTheLimit) {
  ArmedBench b;
  b.hold(BoardBench::regulate(100000, 10000000), 3000);
  EXPECT_GT(b.chambers[0].pressure, 99000);
  EXPECT_LE(b.chambers[0].highest, 100000);
}

TEST(SinewBoard, AboveASetPointsLimitItExhaustsWithoutAFault) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 1000);
  b.chambers[0].pressure = 50100;  // within the hysteresis
  sinew_set_point s = BoardBench::regulate(50000);
  s.limit = 50000;
  b.command(s);
  b.pass(1);
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_EXHAUST);
  EXPECT_EQ(b.chambers[0].duty, 255);
  EXPECT_EQ(b.faults(0), 0);
}

TEST(SinewBoard, OverpressureLatches) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 500);
  b.chambers[0].pressure = 100000 + 250000 / 20 + 100;
  b.pass(1);
  EXPECT_EQ(b.faults(0), SINEW_FAULT_OVERPRESSURE);
  EXPECT_EQ(b.faults(1), 0);
  b.hold(BoardBench::regulate(50000), 2000);
  EXPECT_EQ(b.mode(0), SINEW_VENT);
  EXPECT_LT(b.chambers[0].pressure, 100);
  EXPECT_NEAR(b.chambers[1].pressure, 50000, 450) << "its neighbour goes on";
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 1), SINEW_ACCEPTED);
  b.pass(20);
  EXPECT_EQ(b.mode(0), SINEW_VENT) << "clearing alone moves nothing";
  b.hold(BoardBench::regulate(50000), 1000);
  EXPECT_NEAR(b.chambers[0].pressure, 50000, 450);
}

TEST(SinewBoard, SilenceVentsWithinTheTimeout) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 1000);
  b.command(BoardBench::regulate(50000));
  b.pass(100);
  EXPECT_EQ(b.mode(0), SINEW_REGULATE);
  b.pass(1);
  EXPECT_EQ(b.mode(0), SINEW_VENT);
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_EXHAUST);
  EXPECT_EQ(b.faults(0), SINEW_FAULT_TIMEOUT);
  b.hold(BoardBench::regulate(50000), 200);
  EXPECT_EQ(b.mode(0), SINEW_VENT) << "latched";
}

TEST(SinewBoard, ReadingFeedsNoTimeoutAndRefusedSetPointsNeither) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 500);
  const std::uint16_t last = b.sequence;
  for (int n = 0; n < 12; ++n) {
    b.state();
    EXPECT_EQ(b.command(BoardBench::regulate(50000), last), SINEW_STALE);
    EXPECT_EQ(b.command(BoardBench::regulate(100001), static_cast<std::uint16_t>(last + 1)), SINEW_OUT_OF_RANGE);
    b.pass(10);
  }
  EXPECT_EQ(b.faults(0), SINEW_FAULT_TIMEOUT);
}

TEST(SinewBoard, SilenceSealsWhereThatIsConfigured) {
  BoardBench b;
  sinew_configuration c = BoardBench::makeConfiguration();
  c.channels[1].on_timeout = SINEW_SEAL;
  ASSERT_EQ(sinew_board_configure(&b.board, &c), SINEW_ACCEPTED);
  b.hold(BoardBench::regulate(50000), 1000);
  b.pass(2000);
  EXPECT_EQ(b.mode(0), SINEW_VENT);
  EXPECT_EQ(b.mode(1), SINEW_SEAL);
  EXPECT_LT(b.chambers[0].pressure, 100);
  EXPECT_NEAR(b.chambers[1].pressure, 50000, 450);
  EXPECT_EQ(b.command({SINEW_VENT, 0, 0, 0}), SINEW_ACCEPTED);
  EXPECT_EQ(b.mode(1), SINEW_VENT) << "a sealed channel may always be vented";
}

TEST(SinewBoard, EmergencyStopVentsWhatIsSealed) {
  BoardBench b;
  sinew_configuration c = BoardBench::makeConfiguration();
  c.channels[1].on_timeout = SINEW_SEAL;
  ASSERT_EQ(sinew_board_configure(&b.board, &c), SINEW_ACCEPTED);
  b.hold(BoardBench::regulate(50000), 1000);
  b.pass(200);
  ASSERT_EQ(b.mode(1), SINEW_SEAL);
  b.stop = true;
  b.pass(1);
  EXPECT_EQ(b.mode(1), SINEW_VENT);
  EXPECT_EQ(b.chambers[1].path, SINEW_PATH_EXHAUST);
}

TEST(SinewBoard, ASealedChannelLetsNothingAboveItsMaximum) {
  ArmedBench b;
  b.hold(BoardBench::regulate(95000), 1000);
  b.command({SINEW_SEAL, 0, 0, 1});
  b.pass(1);
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_CLOSED);
  b.chambers[0].pressure = 105000;  // pressed from outside
  b.pass(1);
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_EXHAUST);
  b.pass(60);
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_CLOSED);
  EXPECT_EQ(b.faults(0), 0);
}

TEST(SinewBoard, AVentedChannelNeedsNoSetPoints) {
  ArmedBench b;
  b.command({SINEW_VENT, 0, 0, 0});
  b.pass(5000);
  EXPECT_EQ(b.faults(0), 0);
}

TEST(SinewBoard, SequencesRiseWithinHalfTheRangeAndWrap) {
  ArmedBench b;
  const sinew_set_point s = BoardBench::regulate(100);
  EXPECT_EQ(b.command(s, 40000), SINEW_ACCEPTED) << "the first may have any";
  EXPECT_EQ(b.command(s, 40000), SINEW_STALE);
  EXPECT_EQ(b.command(s, 39999), SINEW_STALE);
  EXPECT_EQ(b.command(s, static_cast<std::uint16_t>(40000 + 32768)), SINEW_STALE);
  EXPECT_EQ(b.command(s, static_cast<std::uint16_t>(40000 + 32767)), SINEW_ACCEPTED);
  EXPECT_EQ(b.command(s, 39998), SINEW_ACCEPTED) << "32767 ahead of 7231, through the wrap";
}

TEST(SinewBoard, LimitsDoNotMoveUnderPressure) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 200);
  sinew_configuration c = BoardBench::makeConfiguration();
  EXPECT_EQ(sinew_board_configure(&b.board, &c), SINEW_ACCEPTED) << "changes nothing";
  c.channels[0].maximum = 90000;
  EXPECT_EQ(sinew_board_configure(&b.board, &c), SINEW_BUSY);
  b.command({SINEW_VENT, 0, 0, 0});
  EXPECT_EQ(sinew_board_configure(&b.board, &c), SINEW_ACCEPTED);
  EXPECT_EQ(b.command(BoardBench::regulate(50000)), SINEW_OUT_OF_RANGE) << "its limit is above the new maximum";
}

TEST(SinewBoard, RefusesConfigurationsThatItCannotKeep) {
  BoardBench b;
  const auto refuses = [&b](const sinew_configuration& c) { return sinew_board_configure(&b.board, &c); };
  sinew_configuration c = BoardBench::makeConfiguration();
  c.count = 1;
  EXPECT_EQ(refuses(c), SINEW_WRONG_COUNT);
  for (const int timeout : {0, 19, 5001}) {
    c = BoardBench::makeConfiguration();
    c.timeout = static_cast<std::uint16_t>(timeout);
    EXPECT_EQ(refuses(c), SINEW_OUT_OF_RANGE);
  }
  for (const int maximum : {-1, 200001}) {
    c = BoardBench::makeConfiguration();
    c.channels[1].maximum = maximum;
    EXPECT_EQ(refuses(c), SINEW_OUT_OF_RANGE);
  }
  for (const std::uint32_t ramp : {0u, 10000001u}) {
    c = BoardBench::makeConfiguration();
    c.channels[1].ramp = ramp;
    EXPECT_EQ(refuses(c), SINEW_OUT_OF_RANGE);
  }
  c = BoardBench::makeConfiguration();
  c.channels[0].on_timeout = SINEW_REGULATE;
  EXPECT_EQ(refuses(c), SINEW_OUT_OF_RANGE);
  EXPECT_FALSE(b.board.armed);
}

TEST(SinewBoard, ABrokenSensorVentsItsChannelAfterThreeReadings) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 1000);
  b.chambers[0].broken = true;
  b.pass(1);
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_CLOSED);
  b.pass(2);
  EXPECT_EQ(b.faults(0), SINEW_FAULT_SENSOR);
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_EXHAUST);
  EXPECT_EQ(b.faults(1), 0);
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 3), SINEW_BUSY);
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 2), SINEW_ACCEPTED) << "another channel";
  b.chambers[0].broken = false;
  b.pass(1);
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 3), SINEW_ACCEPTED);
}

TEST(SinewBoard, OneImplausibleReadingIsNoFault) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 1000);
  b.chambers[0].broken = true;
  b.pass(2);
  b.chambers[0].broken = false;
  b.hold(BoardBench::regulate(50000), 100);
  EXPECT_EQ(b.faults(0), 0);
  EXPECT_NEAR(b.state().channels[0].pressure, 50000, 450);
}

TEST(SinewBoard, EmergencyStopVentsAllAndStandsUntilReleasedAndCleared) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 500);
  b.stop = true;
  b.pass(1);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(b.faults(i), SINEW_FAULT_STOP);
    EXPECT_EQ(b.chambers[i].path, SINEW_PATH_EXHAUST);
  }
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 3), SINEW_BUSY);
  EXPECT_NE(b.state().flags & SINEW_FLAG_STOP, 0);
  b.stop = false;
  b.hold(BoardBench::regulate(50000), 50);
  EXPECT_EQ(b.mode(0), SINEW_VENT);
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 3), SINEW_ACCEPTED);
}

TEST(SinewBoard, SupplyAndTemperatureVentAll) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 500);
  b.supply = 9000;
  b.pass(2);
  EXPECT_EQ(b.faults(0), 0) << "a dip";
  b.pass(1);
  EXPECT_EQ(b.faults(0), SINEW_FAULT_SUPPLY);
  b.supply = 12000;
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 3), SINEW_ACCEPTED);
  b.temperature = 701;
  b.pass(1);
  EXPECT_EQ(b.faults(1), SINEW_FAULT_TEMPERATURE);
  EXPECT_EQ(sinew_board_clear_faults(&b.board, 3), SINEW_BUSY);
}

TEST(SinewBoard, PumpKeepsTheTankWhileAnythingRegulates) {
  ArmedBench b;
  b.tank = 100000;
  b.pass(10);
  EXPECT_FALSE(b.pump) << "nobody needs it";
  b.hold(BoardBench::regulate(50000), 20);
  EXPECT_TRUE(b.pump);
  b.tank = 230000;
  b.hold(BoardBench::regulate(50000), 20);
  EXPECT_TRUE(b.pump) << "up to the upper mark";
  b.tank = 250000;
  b.hold(BoardBench::regulate(50000), 20);
  EXPECT_FALSE(b.pump);
  b.tank = 230000;
  b.hold(BoardBench::regulate(50000), 20);
  EXPECT_FALSE(b.pump) << "down to the lower mark";
  b.tank = 100000;
  b.hold(BoardBench::regulate(50000), 990);
  EXPECT_EQ(b.faults(0), 0);
  b.hold(BoardBench::regulate(50000), 30);
  EXPECT_EQ(b.faults(0), SINEW_FAULT_SOURCE);
}

TEST(SinewBoard, BeginsToRegulateWhereThePressureIs) {
  ArmedBench b;
  b.chambers[0].pressure = 30000;
  b.pass(1);  // still venting
  const double found = b.chambers[0].pressure;
  b.command(BoardBench::regulate(static_cast<std::int32_t>(found), 1000));
  b.pass(50);
  EXPECT_NEAR(b.chambers[0].pressure, found, 450);
}

TEST(SinewBoard, AKinkedHoseDoesNotWindUp) {
  ArmedBench b;
  b.hold(BoardBench::regulate(0), 50);
  b.fill_rate = 0;
  b.hold(BoardBench::regulate(90000), 1000);
  EXPECT_LE(b.board.channels[0].reference, 2 * 200 + 2500 + 200) << "not far ahead of what is measured";
}

TEST(SinewBoard, TheClockMayWrap) {
  BoardBench b;
  b.now = 0xFFFFFFFFu - 300;
  b.restart();
  const sinew_configuration c = BoardBench::makeConfiguration();
  sinew_board_configure(&b.board, &c);
  b.hold(BoardBench::regulate(50000), 1000);
  EXPECT_EQ(b.faults(0), 0);
  EXPECT_NEAR(b.chambers[0].pressure, 50000, 450);
  EXPECT_EQ(b.state().uptime, 1000u);
}

TEST(SinewBoard, ARestartIsVentedUnarmedAndYoung) {
  ArmedBench b;
  b.hold(BoardBench::regulate(50000), 1000);
  b.restart();
  EXPECT_EQ(b.chambers[0].path, SINEW_PATH_EXHAUST);
  EXPECT_EQ(b.state().uptime, 0u);
  EXPECT_EQ(b.state().flags & SINEW_FLAG_ARMED, 0);
  EXPECT_EQ(b.state().age, SINEW_NO_AGE);
  EXPECT_EQ(b.command(BoardBench::regulate(50000)), SINEW_NOT_ARMED);
}

}  // namespace
}  // namespace sinew
