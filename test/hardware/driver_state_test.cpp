#include "sinew/hardware/driver_state.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

namespace sinew {
namespace {

using S = DriverState;
using E = DriverEvent;

// What matters most holds before the program runs.
static_assert(nextState(S::kOff, E::kCommand) == S::kOff, "a command never wakes a driver that is off");
static_assert(nextState(S::kReady, E::kCommand) == S::kActive, "");
static_assert(nextState(S::kActive, E::kCommandLost) == S::kHolding, "");
static_assert(nextState(S::kHolding, E::kHoldLimit) == S::kSafe, "");
static_assert(nextState(S::kSafe, E::kCommand) == S::kSafe, "safe is latched");
static_assert(nextState(S::kFault, E::kCommand) == S::kFault, "fault is latched");
static_assert(nextState(S::kFault, E::kPrepared) == S::kFault, "");

// Every arrow there is; every other pair of state and event leads nowhere.
const std::map<std::pair<S, E>, S>& arrows() {
  static const std::map<std::pair<S, E>, S> kArrows = {
      {{S::kOff, E::kInit}, S::kInitialising},      {{S::kInitialising, E::kPrepared}, S::kReady},
      {{S::kInitialising, E::kHalt}, S::kSafe},     {{S::kInitialising, E::kFailure}, S::kFault},
      {{S::kInitialising, E::kShutdown}, S::kOff},  {{S::kReady, E::kInit}, S::kInitialising},
      {{S::kReady, E::kCommand}, S::kActive},       {{S::kReady, E::kHalt}, S::kSafe},
      {{S::kReady, E::kFailure}, S::kFault},        {{S::kReady, E::kShutdown}, S::kOff},
      {{S::kActive, E::kCommandLost}, S::kHolding}, {{S::kActive, E::kHoldLimit}, S::kSafe},
      {{S::kActive, E::kHalt}, S::kSafe},           {{S::kActive, E::kFailure}, S::kFault},
      {{S::kActive, E::kShutdown}, S::kOff},        {{S::kHolding, E::kCommand}, S::kActive},
      {{S::kHolding, E::kRecover}, S::kReady},      {{S::kHolding, E::kHoldLimit}, S::kSafe},
      {{S::kHolding, E::kHalt}, S::kSafe},          {{S::kHolding, E::kFailure}, S::kFault},
      {{S::kHolding, E::kShutdown}, S::kOff},       {{S::kSafe, E::kInit}, S::kInitialising},
      {{S::kSafe, E::kRecover}, S::kInitialising},  {{S::kSafe, E::kFailure}, S::kFault},
      {{S::kSafe, E::kShutdown}, S::kOff},          {{S::kFault, E::kInit}, S::kInitialising},
      {{S::kFault, E::kRecover}, S::kInitialising}, {{S::kFault, E::kShutdown}, S::kOff},
  };
  return kArrows;
}

TEST(DriverState, EveryPairLeadsWhereItShould) {
  for (int s = 0; s < kDriverStates; ++s) {
    for (int e = 0; e < kDriverEvents; ++e) {
      const auto state = static_cast<S>(s);
      const auto event = static_cast<E>(e);
      const auto arrow = arrows().find({state, event});
      const S expected = arrow == arrows().end() ? state : arrow->second;
      EXPECT_EQ(nextState(state, event), expected) << name(state) << " event " << e;
    }
  }
}

// Walks every sequence of events from every state: motion is reached only through ready, never straight out of a latch.
TEST(DriverState, ActiveIsReachedFromReadyAndHoldingOnly) {
  for (int s = 0; s < kDriverStates; ++s)
    for (int e = 0; e < kDriverEvents; ++e) {
      const auto from = static_cast<S>(s);
      if (nextState(from, static_cast<E>(e)) != S::kActive || from == S::kActive) continue;
      EXPECT_TRUE(from == S::kReady || from == S::kHolding) << name(from);
      EXPECT_EQ(static_cast<E>(e), E::kCommand);
    }
}

TEST(DriverState, LatchesOpenOnlyByHand) {
  for (const S latched : {S::kSafe, S::kFault}) {
    std::set<S> reached{latched};
    const E automatic[] = {E::kPrepared, E::kCommand, E::kCommandLost, E::kHoldLimit, E::kFailure};
    for (int round = 0; round < kDriverStates; ++round)
      for (const S s : std::set<S>(reached))
        for (const E e : automatic) reached.insert(nextState(s, e));
    for (const S s : reached) EXPECT_FALSE(servesDevices(s)) << name(latched) << " leads to " << name(s);
  }
}

TEST(DriverState, ShutdownAlwaysWorks) {
  for (int s = 0; s < kDriverStates; ++s) EXPECT_EQ(nextState(static_cast<S>(s), E::kShutdown), S::kOff);
}

TEST(DriverState, DevicesAreServedOnlyWhereTheCommandPathIsAlive) {
  EXPECT_FALSE(servesDevices(S::kOff));
  EXPECT_FALSE(servesDevices(S::kInitialising));
  EXPECT_TRUE(servesDevices(S::kReady));
  EXPECT_TRUE(servesDevices(S::kActive));
  EXPECT_TRUE(servesDevices(S::kHolding));
  EXPECT_FALSE(servesDevices(S::kSafe));
  EXPECT_FALSE(servesDevices(S::kFault));
}

}  // namespace
}  // namespace sinew
