#include "sinew/hardware/cia402.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "sinew/hardware/actuator_reading.h"

namespace sinew::cia402 {
namespace {

// CiA 402-2, table "State coding": x where a bit does not count, from bit 6 down, without bit 4.
struct Pattern {
  const char* bits;  // 6 5 3 2 1 0
  State state;
};
constexpr Pattern kPatterns[] = {{"0x0000", State::kNotReady},         {"1x0000", State::kSwitchOnDisabled},
                                 {"010001", State::kReadyToSwitchOn},  {"010011", State::kSwitchedOn},
                                 {"010111", State::kOperationEnabled}, {"000111", State::kQuickStopActive},
                                 {"0x1111", State::kFaultReaction},    {"0x1000", State::kFault}};

bool matches(unsigned word, const char* bits) {
  constexpr int kPlaces[] = {6, 5, 3, 2, 1, 0};
  for (int i = 0; i < 6; ++i)
    if (bits[i] != 'x' && static_cast<unsigned>(bits[i] - '0') != (word >> kPlaces[i] & 1u)) return false;
  return true;
}

TEST(Cia402, EveryStatusword) {
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    State expected = State::kNotReady;
    for (const Pattern& p : kPatterns)
      if (matches(word, p.bits)) expected = p.state;
    ASSERT_EQ(calcState(static_cast<std::uint16_t>(word)), expected) << word;
  }
}

// maxon EPOS4 firmware specification, "State of the drive": statuswords as its table prints them.
TEST(Cia402, StatuswordsOfADrive) {
  EXPECT_EQ(calcState(0x0040), State::kSwitchOnDisabled);
  EXPECT_EQ(calcState(0x0621), State::kReadyToSwitchOn);
  EXPECT_EQ(calcState(0x0633), State::kSwitchedOn);
  EXPECT_EQ(calcState(0x1637), State::kOperationEnabled);
  EXPECT_EQ(calcState(0x0617), State::kQuickStopActive);
  EXPECT_EQ(calcState(0x0208), State::kFault);
}

// The transitions of CiA 402-2, "Power drive system finite state automaton", that a controlword makes.
State follow(State from, std::uint16_t word, std::uint16_t last) {
  switch (from) {
    case State::kFault:
      return (word & ~last & 0x80) != 0 ? State::kSwitchOnDisabled : from;
    case State::kSwitchOnDisabled:
      return (word & 0x87) == 0x06 ? State::kReadyToSwitchOn : from;
    case State::kReadyToSwitchOn:
      return (word & 0x8F) == 0x07 ? State::kSwitchedOn : from;
    case State::kSwitchedOn:
      return (word & 0x8F) == 0x0F ? State::kOperationEnabled : from;
    case State::kQuickStopActive:
      return (word & 0x8F) == 0x0F ? State::kOperationEnabled : from;
    default:
      return from;
  }
}

TEST(Cia402, ControlwordsLeadToOperationFromEverywhere) {
  for (const State start : {State::kFault, State::kSwitchOnDisabled, State::kReadyToSwitchOn, State::kSwitchedOn,
                            State::kQuickStopActive, State::kOperationEnabled}) {
    for (const std::uint16_t before : {kDisableVoltage, kFaultReset, kEnableOperation}) {
      State state = start;
      std::uint16_t last = before;
      int steps = 0;
      while (state != State::kOperationEnabled && ++steps < 10) {
        const std::uint16_t word = calcControlword(state, last);
        state = follow(state, word, last);
        last = word;
      }
      EXPECT_EQ(state, State::kOperationEnabled) << describe(start);
      EXPECT_LE(steps, 5);
    }
  }
}

TEST(Cia402, WaitsWhereTheDriveMovesOnByItself) {
  EXPECT_EQ(calcControlword(State::kNotReady, 0), kDisableVoltage);
  EXPECT_EQ(calcControlword(State::kFaultReaction, kEnableOperation), kDisableVoltage);
}

TEST(Cia402, EveryStateHasItsOwnWords) {
  std::set<std::string> words;
  for (int i = 0; i < 8; ++i) words.insert(describe(static_cast<State>(i)));
  EXPECT_EQ(words.size(), 8u);
}

// CiA 301 "Emergency error codes", CiA 402-2 "Error codes".
TEST(Cia402, FaultsOfErrorCodes) {
  EXPECT_EQ(calcFault(0x0000), 0u);
  EXPECT_EQ(calcFault(0x1000), kFaultDevice);
  EXPECT_EQ(calcFault(0x2310), kFaultOverload);
  EXPECT_EQ(calcFault(0x3210), kFaultVoltage);
  EXPECT_EQ(calcFault(0x3220), kFaultVoltage | kFaultUndervolted);
  EXPECT_EQ(calcFault(0x4210), kFaultOverheated);
  EXPECT_EQ(calcFault(0x4310), kFaultOverheated);
  EXPECT_EQ(calcFault(0x5530), kFaultElectrical);
  EXPECT_EQ(calcFault(0x6100), kFaultElectrical);
  EXPECT_EQ(calcFault(0x7300), kFaultEncoder);
  EXPECT_EQ(calcFault(0x7121), kFaultDevice);
  EXPECT_EQ(calcFault(0x8130), kFaultWatchdog);
  EXPECT_EQ(calcFault(0x8311), kFaultOverload);
  EXPECT_EQ(calcFault(0x8400), kFaultFollowing);
  EXPECT_EQ(calcFault(0x8611), kFaultFollowing);
  EXPECT_EQ(calcFault(0x9000), kFaultDevice);
  for (unsigned code = 1; code <= 0xFFFF; ++code) EXPECT_NE(calcFault(static_cast<std::uint16_t>(code)), 0u);
}

}  // namespace
}  // namespace sinew::cia402
