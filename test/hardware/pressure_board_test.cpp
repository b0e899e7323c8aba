#include "sinew/hardware/pressure_board.h"

#include <gtest/gtest.h>

#include "hardware/pressure_bench.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

/// A board in the test's hand: answers requests as the protocol says, with what the test wants to be told.
struct Bench {
  Bench() : board(11, makePressureTiming(), makePressureActuators(2)) {
    identity.version = 1;
    identity.channels = 4;
    identity.range_min = -60000;
    identity.range_max = 200000;
    state.count = 4;
    state.flags = kBoardArmed;
    state.accepted = 500;
  }

  PressureAnswer makeAnswer() const {
    PressureAnswer a;
    a.address = 11;
    a.sequence = board.request().sequence;
    switch (board.request().type) {
      case PressureType::kHello:
        a.type = PressureType::kIdentity;
        a.identity = identity;
        break;
      case PressureType::kConfigure:
        a.type = PressureType::kConfiguration;
        a.configuration = board.request().configuration;
        break;
      default:
        a.type = PressureType::kState;
        a.state = state;
        for (std::size_t i = 0; i < 4; ++i)
          if (board.request().type == PressureType::kSetPoints)
            a.state.channels[i].status = static_cast<std::uint8_t>(board.request().set_points[i].mode);
    }
    return a;
  }

  SetUpProgress setUp() {
    board.startSetUp();
    while (board.prepareSetUp(true)) {
      asked.push_back(board.request().type);
      board.take(makeAnswer());
    }
    return board.progress();
  }

  void cycle(const std::vector<double>& set_points) {
    board.prepareSetPoints(set_points.data());
    state.uptime += 10;
    board.take(makeAnswer());
    board.endCycle();
  }

  PressureBoard board;
  PressureIdentity identity;
  PressureState state;
  std::vector<PressureType> asked;
};

TEST(PressureBoard, RefusesSettingsThatContradictEachOther) {
  const auto refuses = [](DeviceTiming timing, const std::vector<PressureActuator>& actuators) {
    try {
      PressureBoard board(11, timing, actuators);
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(refuses(makePressureTiming(), {}).find("none"), std::string::npos);
  std::vector<PressureActuator> actuators = makePressureActuators(2);
  EXPECT_EQ(refuses(makePressureTiming(), actuators), "");
  actuators[1].settings.channel = 0;
  EXPECT_NE(refuses(makePressureTiming(), actuators).find("chamber_2.channel"), std::string::npos);
  actuators = makePressureActuators(2);
  actuators[0].settings.pressure_limit = 79999;
  EXPECT_NE(refuses(makePressureTiming(), actuators).find("80000 Pa"), std::string::npos);
  actuators = makePressureActuators(2);
  actuators[0].bounds.rate_max = 0;
  EXPECT_NE(refuses(makePressureTiming(), actuators).find("rate_max"), std::string::npos);
  for (const double watchdog : {0.019, 5.1}) {
    DeviceTiming timing = makePressureTiming();
    timing.watchdog = watchdog;
    EXPECT_NE(refuses(timing, makePressureActuators(2)).find("watchdog"), std::string::npos);
  }
}

TEST(PressureBoard, SetsUpInTheOrderOfTheDocument) {
  Bench b;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone) << b.board.problem();
  const std::vector<PressureType> order{PressureType::kHello, PressureType::kClearFaults, PressureType::kConfigure,
                                        PressureType::kReadState, PressureType::kSetPoints};
  EXPECT_EQ(b.asked, order);
}

TEST(PressureBoard, EnablesAtTheMeasuredPressureAndLeavesOtherChannelsVented) {
  Bench b;
  b.state.channels[0].pressure = 1234;
  b.state.channels[2].pressure = -56;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  const PressureRequest& r = b.board.request();
  ASSERT_EQ(r.type, PressureType::kSetPoints);
  EXPECT_EQ(r.sequence, 501) << "goes on from what the board has accepted";
  EXPECT_EQ(r.count, 4);
  EXPECT_EQ(r.set_points[0].mode, PressureMode::kRegulate);
  EXPECT_EQ(r.set_points[0].pressure, 1234);
  EXPECT_EQ(r.set_points[2].pressure, -56);
  EXPECT_EQ(r.set_points[0].limit, 90000);
  EXPECT_EQ(r.set_points[0].ramp, 120000u);
  EXPECT_EQ(r.set_points[1].mode, PressureMode::kVent);
  EXPECT_EQ(r.set_points[3].mode, PressureMode::kVent);
}

TEST(PressureBoard, GivesUpAfterThreeSilences) {
  Bench b;
  b.board.startSetUp();
  for (int n = 0; n < 2; ++n) {
    ASSERT_TRUE(b.board.prepareSetUp(true));
    b.board.missSetUp();
    EXPECT_EQ(b.board.progress(), SetUpProgress::kBusy);
  }
  ASSERT_TRUE(b.board.prepareSetUp(true));
  b.board.missSetUp();
  EXPECT_EQ(b.board.progress(), SetUpProgress::kFailed);
  EXPECT_FALSE(b.board.prepareSetUp(true));
}

TEST(PressureBoard, NamesWhatDoesNotFit) {
  const auto problem = [](void (*change)(Bench&)) {
    Bench b;
    change(b);
    EXPECT_EQ(b.setUp(), SetUpProgress::kFailed);
    return b.board.problem();
  };
  EXPECT_NE(problem([](Bench& b) { b.identity.version = 2; }).find("version 2"), std::string::npos);
  EXPECT_NE(problem([](Bench& b) { b.identity.channels = 2; }).find("channel 2) does not exist"), std::string::npos);
  EXPECT_NE(problem([](Bench& b) { b.identity.channels = 0; }).find("0 channels"), std::string::npos);
  EXPECT_NE(problem([](Bench& b) { b.identity.range_min = 0; }).find("-20000 Pa"), std::string::npos);
  EXPECT_NE(problem([](Bench& b) { b.state.channels[2].faults = kChannelSensor; }).find("chamber_2"),
            std::string::npos);
}

TEST(PressureBoard, BelievesOnlyTheAnswerToItsOpenRequest) {
  Bench b;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  const double set_points[] = {1000, 1000};
  b.board.prepareSetPoints(set_points);
  PressureAnswer late = b.makeAnswer();
  --late.sequence;
  late.state.channels[0].pressure = 99;
  EXPECT_FALSE(b.board.take(late));
  PressureAnswer fewer = b.makeAnswer();
  fewer.state.count = 3;
  EXPECT_FALSE(b.board.take(fewer));
  EXPECT_FALSE(b.board.answered());
  EXPECT_TRUE(b.board.take(b.makeAnswer()));
  EXPECT_FALSE(b.board.take(b.makeAnswer())) << "a duplicate";
  b.board.endCycle();
  EXPECT_EQ(b.board.readings()[0].measured, 0);
  EXPECT_TRUE(b.board.readings()[0].valid);
}

TEST(PressureBoard, MapsEveryFaultAndKeepsIt) {
  const struct {
    std::uint8_t told;
    std::uint32_t fault;
  } cases[] = {{kChannelSensor, kFaultSensor},    {kChannelOverpressure, kFaultPressure},
               {kChannelTimeout, kFaultWatchdog}, {kChannelStop, kFaultDevice},
               {kChannelSupply, kFaultVoltage},   {kChannelTemperature, kFaultOverheated},
               {kChannelSource, kFaultFollowing}};
  for (const auto& c : cases) {
    Bench b;
    ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
    b.state.channels[2].faults = c.told;
    b.cycle({0, 0});
    b.state.channels[2].faults = 0;
    b.cycle({0, 0});
    EXPECT_EQ(b.board.readings()[1].fault, c.fault);
    EXPECT_FALSE(b.board.faultDetail(1).empty());
    EXPECT_EQ(b.board.readings()[0].fault, 0u);
    EXPECT_TRUE(b.board.faultDetail(0).empty());
  }
}

TEST(PressureBoard, UptimeMayWrapButNotFall) {
  Bench b;
  b.state.uptime = 0xFFFFFFFAu;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.cycle({0, 0});
  b.cycle({0, 0});
  EXPECT_LT(b.state.uptime, 100u);
  EXPECT_EQ(b.board.readings()[0].fault, 0u);
  b.state.uptime -= 15;
  b.cycle({0, 0});
  EXPECT_EQ(b.board.readings()[0].fault, kFaultOff);
}

TEST(PressureBoard, AnUnarmedBoardHasRestarted) {
  Bench b;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.state.flags = 0;
  b.state.refusal = PressureReason::kNotArmed;
  b.cycle({0, 0});
  EXPECT_EQ(b.board.readings()[0].fault & kFaultOff, kFaultOff);
  EXPECT_NE(b.board.faultDetail(0).find("not configured"), std::string::npos);
  EXPECT_EQ(b.board.refusals(), 1u);
}

TEST(PressureBoard, RelaxScalesWhatWasMeasuredAndEndsVented) {
  Bench b;
  b.state.channels[0].pressure = 40000;
  ASSERT_EQ(b.setUp(), SetUpProgress::kDone);
  b.cycle({50000, 1000});
  const bool which[] = {true, false};
  b.board.relax(which, 0.5);
  b.board.prepareSetPoints();
  EXPECT_EQ(b.board.request().set_points[0].pressure, 20000);
  EXPECT_EQ(b.board.request().set_points[2].pressure, 1000);
  const double set_points[] = {60000, 2000};
  b.board.prepareSetPoints(set_points);
  EXPECT_EQ(b.board.request().set_points[0].pressure, 20000) << "stays relaxed";
  b.board.relax(which, 0);
  b.board.prepareSetPoints();
  EXPECT_EQ(b.board.request().set_points[0].mode, PressureMode::kVent);
  EXPECT_EQ(b.board.request().set_points[2].mode, PressureMode::kRegulate);
}

}  // namespace
}  // namespace sinew
