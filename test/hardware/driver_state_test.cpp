#include "sinew/hardware/driver_state.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

#include "hardware/check_line.h"

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
      {{S::kOff, E::kInit}, S::kInitialising},       {{S::kOff, E::kRecover}, S::kInitialising},
      {{S::kInitialising, E::kPrepared}, S::kReady}, {{S::kInitialising, E::kHalt}, S::kSafe},
      {{S::kInitialising, E::kEmergency}, S::kSafe}, {{S::kInitialising, E::kFailure}, S::kFault},
      {{S::kInitialising, E::kShutdown}, S::kOff},   {{S::kReady, E::kInit}, S::kInitialising},
      {{S::kReady, E::kCommand}, S::kActive},        {{S::kReady, E::kHalt}, S::kSafe},
      {{S::kReady, E::kEmergency}, S::kSafe},        {{S::kReady, E::kFailure}, S::kFault},
      {{S::kReady, E::kShutdown}, S::kOff},          {{S::kActive, E::kCommandLost}, S::kHolding},
      {{S::kActive, E::kHoldLimit}, S::kSafe},       {{S::kActive, E::kHalt}, S::kSafe},
      {{S::kActive, E::kEmergency}, S::kSafe},       {{S::kActive, E::kFailure}, S::kFault},
      {{S::kActive, E::kShutdown}, S::kOff},         {{S::kHolding, E::kCommand}, S::kActive},
      {{S::kHolding, E::kRecover}, S::kReady},       {{S::kHolding, E::kHoldLimit}, S::kSafe},
      {{S::kHolding, E::kHalt}, S::kSafe},           {{S::kHolding, E::kEmergency}, S::kSafe},
      {{S::kHolding, E::kFailure}, S::kFault},       {{S::kHolding, E::kShutdown}, S::kOff},
      {{S::kSafe, E::kInit}, S::kInitialising},      {{S::kSafe, E::kRecover}, S::kInitialising},
      {{S::kSafe, E::kFailure}, S::kFault},          {{S::kSafe, E::kShutdown}, S::kOff},
      {{S::kFault, E::kInit}, S::kInitialising},     {{S::kFault, E::kRecover}, S::kInitialising},
      {{S::kFault, E::kShutdown}, S::kOff},
  };
  return kArrows;
}

template <typename Visit>
void forEveryPair(Visit visit) {
  for (int s = 0; s < kDriverStates; ++s)
    for (int e = 0; e < kDriverEvents; ++e) visit(static_cast<S>(s), static_cast<E>(e));
}

/// States that `events` can lead to from `from`, in any order and number.
std::set<S> reach(S from, const std::set<E>& events) {
  std::set<S> reached{from};
  for (int round = 0; round < kDriverStates; ++round)
    for (const S s : std::set<S>(reached))
      for (const E e : events) reached.insert(nextState(s, e));
  return reached;
}

const std::set<E> kByItself = {E::kPrepared, E::kCommand, E::kCommandLost, E::kHoldLimit, E::kFailure, E::kEmergency};

TEST(DriverState, EveryPairLeadsWhereItShould) {
  int pairs = 0, wrong = 0;
  forEveryPair([&](S state, E event) {
    const auto arrow = arrows().find({state, event});
    const S expected = arrow == arrows().end() ? state : arrow->second;
    EXPECT_EQ(nextState(state, event), expected) << name(state) << " event " << static_cast<int>(event);
    ++pairs;
    wrong += nextState(state, event) == expected ? 0 : 1;
  });
  checkAtLeast("safety_states.pairs", pairs, kDriverStates * kDriverEvents, "1");
  checkAtMost("safety_states.wrong", wrong, 0, "1");
}

TEST(DriverState, AnyFaultMakesAnyStateSafe) {
  int unsafe = 0;
  for (int s = 0; s < kDriverStates; ++s)
    for (const E fault : {E::kFailure, E::kEmergency})
      if (!isSafe(nextState(static_cast<S>(s), fault))) ++unsafe;
  checkAtMost("safety_states.unsafe_after_fault", unsafe, 0, "1");
}

// Every walk of any length: what is reachable is the closure, whatever the order of events.
TEST(DriverState, NothingButAPersonLeadsOutOfSafety) {
  int escapes = 0;
  for (const S latched : {S::kOff, S::kSafe, S::kFault})
    for (const S s : reach(latched, kByItself)) escapes += isSafe(s) ? 0 : 1;
  checkAtMost("safety_states.escapes", escapes, 0, "1");
}

TEST(DriverState, MotionIsReachedThroughReadyOnly) {
  forEveryPair([](S from, E event) {
    if (nextState(from, event) != S::kActive || from == S::kActive) return;
    EXPECT_TRUE(from == S::kReady || from == S::kHolding) << name(from);
    EXPECT_EQ(event, E::kCommand);
  });
  forEveryPair([](S from, E event) {
    if (nextState(from, event) != S::kReady || from == S::kReady) return;
    EXPECT_TRUE(event == E::kPrepared || event == E::kRecover) << name(from);
  });
}

TEST(DriverState, FromEveryStateAPersonGetsToReady) {
  for (int s = 0; s < kDriverStates; ++s) {
    const std::set<S> reached = reach(static_cast<S>(s), {E::kInit, E::kRecover, E::kPrepared});
    EXPECT_TRUE(reached.count(S::kReady) == 1 || static_cast<S>(s) == S::kActive) << name(static_cast<S>(s));
  }
}

TEST(DriverState, ShutdownAlwaysWorks) {
  for (int s = 0; s < kDriverStates; ++s) EXPECT_EQ(nextState(static_cast<S>(s), E::kShutdown), S::kOff);
}

TEST(DriverState, DevicesAreServedOnlyWhereTheCommandPathIsAlive) {
  for (const S s : {S::kReady, S::kActive, S::kHolding}) EXPECT_TRUE(servesDevices(s));
  for (const S s : {S::kOff, S::kInitialising, S::kSafe, S::kFault}) EXPECT_FALSE(servesDevices(s));
  for (int s = 0; s < kDriverStates; ++s)
    if (isSafe(static_cast<S>(s))) {
      EXPECT_FALSE(servesDevices(static_cast<S>(s))) << "silence is what trips the devices' own watchdogs";
    }
}

}  // namespace
}  // namespace sinew
