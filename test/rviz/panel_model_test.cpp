#include "panel_model.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <set>

#include "sinew/hardware/actuator_reading.h"

namespace sinew {
namespace {

constexpr std::uint8_t kStates = 7;

ActuatorState makeDriver(std::uint8_t state) {
  ActuatorState message;
  message.driver_state = state;
  message.name = {"cable", "chamber"};
  message.mode = {0, 2};
  message.measured = {0.0123, 21500};
  message.measured_valid = {1, 1};
  message.applied = {0.0125, 22000};
  message.limit_min = {-0.03, 0};
  message.limit_max = {0.06, 40000};
  message.effort = {3.26, 21500};
  message.temperature = {31.4, 0};
  message.zero_valid = {1, 1};
  message.fault = {0, 0};
  return message;
}

ControllerState makeController(std::uint8_t status) {
  ControllerState message;
  message.status = status;
  message.period = 0.010;
  StageTime cycle;
  cycle.stage = "cycle";
  cycle.last = 0.001;
  cycle.median = 0.0042;
  cycle.maximum = 0.0091;
  message.stages = {StageTime(), cycle};
  return message;
}

Heard<ActuatorState> heard(const ActuatorState& message, double age = 0) {
  return {boost::make_shared<const ActuatorState>(message), age};
}

Heard<ControllerState> heard(const ControllerState& message, double age = 0) {
  return {boost::make_shared<const ControllerState>(message), age};
}

PanelView viewOf(const ActuatorState& driver) {
  return calcPanelView(heard(driver), heard(makeController(ControllerState::TRACKING)), false);
}

bool possible(const PanelView& view, Verb verb) {
  return view.possible[static_cast<std::size_t>(verb)];
}

std::set<int> statesThatAllow(Verb verb, bool stopped) {
  std::set<int> states;
  for (std::uint8_t state = 0; state < kStates; ++state) {
    ActuatorState driver = makeDriver(state);
    driver.emergency_stop = stopped;
    if (possible(calcPanelView(heard(driver), heard(makeController(ControllerState::DISABLED)), false), verb))
      states.insert(state);
  }
  return states;
}

// --- States and buttons ---

TEST(PanelModel, namesEveryState) {
  const char* const names[kStates] = {"OFF", "INITIALISING", "READY", "ACTIVE", "HOLDING", "SAFE", "FAULT"};
  for (std::uint8_t state = 0; state < kStates; ++state) {
    ActuatorState driver = makeDriver(state);
    driver.reason = "because";
    const PanelView view = viewOf(driver);
    EXPECT_EQ(view.driver.text, names[state]);
    EXPECT_EQ(view.driver_reason.text, "because");
    EXPECT_EQ(view.driver.tone == Tone::kGood, state == ActuatorState::READY || state == ActuatorState::ACTIVE);
    EXPECT_EQ(view.driver.tone == Tone::kBad, state == ActuatorState::FAULT);
  }
  EXPECT_EQ(viewOf(makeDriver(200)).driver.tone, Tone::kBad);
}

// The transitions in driver_state.h, but `init` where a driver that holds would lose its zeros.
TEST(PanelModel, offersWhatTheDriverTakes) {
  using S = ActuatorState;
  EXPECT_EQ(statesThatAllow(Verb::kInit, false), (std::set<int>{S::OFF, S::SAFE, S::FAULT}));
  EXPECT_EQ(statesThatAllow(Verb::kRecover, false), (std::set<int>{S::OFF, S::HOLDING, S::SAFE, S::FAULT}));
  EXPECT_EQ(statesThatAllow(Verb::kHalt, false), (std::set<int>{S::INITIALISING, S::READY, S::ACTIVE, S::HOLDING}));
  EXPECT_EQ(statesThatAllow(Verb::kEnable, false), (std::set<int>{S::READY, S::ACTIVE, S::HOLDING}));
}

TEST(PanelModel, offersNoWayOutOfAPressedStop) {
  EXPECT_TRUE(statesThatAllow(Verb::kInit, true).empty());
  EXPECT_EQ(statesThatAllow(Verb::kRecover, true).count(ActuatorState::SAFE), 0u);
  EXPECT_EQ(statesThatAllow(Verb::kRecover, true).count(ActuatorState::FAULT), 0u);
}

TEST(PanelModel, offersEnableOrDisable) {
  for (std::uint8_t status = 0; status < 4; ++status) {
    const PanelView view = calcPanelView(heard(makeDriver(ActuatorState::READY)), heard(makeController(status)), false);
    EXPECT_EQ(possible(view, Verb::kEnable), status == ControllerState::DISABLED);
    EXPECT_EQ(possible(view, Verb::kDisable), status != ControllerState::DISABLED);
  }
}

TEST(PanelModel, tellsWhoPressedTheStop) {
  ActuatorState driver = makeDriver(ActuatorState::ACTIVE);
  const auto stop = [&](bool pressed) {
    return calcPanelView(heard(driver), Heard<ControllerState>{}, pressed).stop.text;
  };
  EXPECT_EQ(stop(false), "EMERGENCY STOP");
  EXPECT_NE(stop(true).find("not confirmed"), std::string::npos);
  driver.emergency_stop = true;
  EXPECT_NE(stop(false).find("elsewhere"), std::string::npos);
  EXPECT_NE(stop(true).find("STOPPED"), std::string::npos);
}

// --- Age ---

TEST(PanelModel, saysSoBeforeTheFirstMessage) {
  const PanelView view = calcPanelView({}, {}, false);
  EXPECT_EQ(view.driver.text, "NO DATA");
  EXPECT_EQ(view.controller.text, "NO DATA");
  EXPECT_TRUE(view.actuators.empty());
  for (const bool any : view.possible) EXPECT_FALSE(any);
}

TEST(PanelModel, showsNothingStaleAsFresh) {
  const ActuatorState driver = makeDriver(ActuatorState::ACTIVE);
  const ControllerState controller = makeController(ControllerState::TRACKING);
  const PanelView view = calcPanelView(heard(driver, 0.51), heard(controller, 2.04), false);
  EXPECT_EQ(view.driver.text, "STALE");
  EXPECT_EQ(view.driver_reason.text, "silent for 0.5 s; last: active");
  EXPECT_EQ(view.controller_reason.text, "silent for 2.0 s; last: TRACKING");
  for (const PanelText* text :
       {&view.driver, &view.driver_reason, &view.controller, &view.controller_reason, &view.cycle, &view.counters})
    EXPECT_EQ(text->tone, Tone::kStale) << text->text;
  for (const ActuatorRow& row : view.actuators) EXPECT_EQ(row.tone, Tone::kStale);
  for (const bool any : view.possible) EXPECT_FALSE(any);
}

TEST(PanelModel, isFreshUpToHalfASecond) {
  const PanelView view = calcPanelView(heard(makeDriver(ActuatorState::ACTIVE), 0.5),
                                       heard(makeController(ControllerState::TRACKING), 0.5), false);
  EXPECT_EQ(view.driver.text, "ACTIVE");
  EXPECT_EQ(view.controller.text, "TRACKING");
  EXPECT_TRUE(possible(view, Verb::kHalt));
}

TEST(PanelModel, doesNotEnableOnAStaleDriver) {
  const PanelView view = calcPanelView(heard(makeDriver(ActuatorState::READY), 1),
                                       heard(makeController(ControllerState::DISABLED)), false);
  EXPECT_FALSE(possible(view, Verb::kEnable));
}

// --- Time ---

TEST(PanelModel, showsTheCycleInMilliseconds) {
  ControllerState controller = makeController(ControllerState::TRACKING);
  controller.deadline_misses = 7;
  const ActuatorState driver = makeDriver(ActuatorState::ACTIVE);
  PanelView view = calcPanelView(heard(driver), heard(controller), false);
  EXPECT_EQ(view.cycle.text, "4.2 ms median, 9.1 ms worst of 10.0 ms");
  EXPECT_EQ(view.cycle.tone, Tone::kPlain);
  EXPECT_EQ(view.counters.text, "7 cycles missed, 0 commands refused");

  controller.stages[1].maximum = 0.0101;
  controller.overload_level = 2;
  view = calcPanelView(heard(driver), heard(controller), false);
  EXPECT_EQ(view.cycle.tone, Tone::kCaution);
  EXPECT_EQ(view.counters.text, "7 cycles missed, 0 commands refused, overload 2");
  EXPECT_EQ(view.counters.tone, Tone::kCaution);
}

TEST(PanelModel, addsUpRefusedCommands) {
  ActuatorState driver = makeDriver(ActuatorState::ACTIVE);
  driver.accepted = 1000000;
  driver.rejected_session = 1;
  driver.rejected_sequence = 20;
  driver.rejected_malformed = 300;
  driver.rejected_not_finite = 4000;
  driver.rejected_state = 50000;
  EXPECT_NE(viewOf(driver).counters.text.find("54321 commands refused"), std::string::npos);
}

// --- Actuators ---

TEST(PanelModel, showsACableInMillimetresAndAChamberInKilopascals) {
  const PanelView view = viewOf(makeDriver(ActuatorState::ACTIVE));
  ASSERT_EQ(view.actuators.size(), 2u);
  const ActuatorRow& cable = view.actuators[0];
  EXPECT_EQ(cable.applied_text, "12.50 mm");
  EXPECT_EQ(cable.measured_text, "12.30 mm");
  EXPECT_EQ(cable.effort, "3.3 N");
  EXPECT_EQ(cable.temperature, "31 °C");
  EXPECT_EQ(cable.range, "-30.00 mm to 60.00 mm");
  EXPECT_NEAR(cable.low, -30, 1e-12);
  EXPECT_NEAR(cable.high, 60, 1e-12);
  EXPECT_NEAR(cable.measured, 12.3, 1e-12);
  EXPECT_NEAR(cable.applied, 12.5, 1e-12);
  const ActuatorRow& chamber = view.actuators[1];
  EXPECT_EQ(chamber.applied_text, "22.0 kPa");
  EXPECT_EQ(chamber.effort, "21.5 kPa");
  EXPECT_EQ(chamber.temperature, "–") << "no temperature is told";
  EXPECT_NEAR(chamber.high, 40, 1e-12);
}

TEST(PanelModel, marksWhatIsWrongWithAnActuator) {
  ActuatorState driver = makeDriver(ActuatorState::FAULT);
  driver.fault[0] = kFaultOverheated | kFaultSilent;
  driver.measured_valid[1] = 0;
  driver.zero_valid[1] = 0;
  const PanelView view = viewOf(driver);
  EXPECT_EQ(view.actuators[0].tone, Tone::kBad);
  EXPECT_NE(view.actuators[0].faults.find("overheated"), std::string::npos);
  EXPECT_NE(view.actuators[0].faults.find("answer"), std::string::npos);
  EXPECT_EQ(view.actuators[1].tone, Tone::kCaution);
  EXPECT_TRUE(view.actuators[1].faults.empty());
  EXPECT_TRUE(view.actuators[0].zero_valid);
  EXPECT_FALSE(view.actuators[1].zero_valid);
}

TEST(PanelModel, hasWordsForEveryFaultBitAndRepeatsNone) {
  ActuatorState driver = makeDriver(ActuatorState::FAULT);
  std::set<std::string> words;
  for (int bit = 0; bit <= 16; ++bit) {
    driver.fault[0] = 1u << bit;
    words.insert(viewOf(driver).actuators[0].faults);
  }
  EXPECT_EQ(words.size(), 17u);
  EXPECT_EQ(words.count(""), 0u);
  driver.fault[0] = 1u << 30 | 1u << 31;  // of a later driver
  EXPECT_EQ(viewOf(driver).actuators[0].faults, "reports an unknown error");
}

TEST(PanelModel, survivesShortArraysAndNumbersThatAreNone) {
  ActuatorState driver;
  driver.name = {"cable"};
  driver.measured = {std::nan("")};
  const PanelView view = viewOf(driver);
  ASSERT_EQ(view.actuators.size(), 1u);
  EXPECT_EQ(view.actuators[0].measured_text, "–");
  EXPECT_EQ(view.actuators[0].applied_text, "–");
  EXPECT_EQ(view.actuators[0].low, view.actuators[0].high) << "the range is not known";
  EXPECT_EQ(view.actuators[0].range, "");
  EXPECT_NE(view.actuators[0].tone, Tone::kPlain) << "nothing was measured";
}

}  // namespace
}  // namespace sinew
