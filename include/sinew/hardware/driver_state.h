#pragma once

#include <cstdint>

namespace sinew {

/// States of the hardware driver; the numbers are those of the message ActuatorState.
enum class DriverState : std::uint8_t {
  kOff,           ///< devices limp or untouched
  kInitialising,  ///< connecting, configuring, homing
  kReady,         ///< holding the measured position, waiting for the first command
  kActive,        ///< following commands
  kHolding,       ///< commands stopped: holding the last set point
  kSafe,          ///< latched: every actuator in its safe behaviour
  kFault          ///< latched: a device, the line or a zero was lost
};

enum class DriverEvent : std::uint8_t {
  kInit,         ///< asked to connect and to home everything
  kPrepared,     ///< set-up and homing done
  kCommand,      ///< a command that may be followed from here without a jump
  kCommandLost,  ///< none for the command timeout
  kHoldLimit,    ///< held, by the controller or by the driver, for too long
  kFailure,      ///< device, line, zero, watch or set-up failed
  kEmergency,    ///< somebody hit the emergency stop
  kRecover,
  kHalt,
  kShutdown
};

constexpr int kDriverStates = 7;
constexpr int kDriverEvents = 10;

/// The whole of the driver's safety logic: where `event` leads from `state`. An event that means nothing in a state, or
/// is not allowed in it, leads nowhere.
constexpr DriverState nextState(DriverState state, DriverEvent event) {
  using S = DriverState;
  using E = DriverEvent;
  if (event == E::kShutdown) return S::kOff;
  if (event == E::kFailure) return state == S::kOff ? S::kOff : S::kFault;
  if (event == E::kEmergency) return state == S::kOff || state == S::kFault ? state : S::kSafe;
  switch (state) {
    case S::kOff:
      return event == E::kInit || event == E::kRecover ? S::kInitialising : state;
    case S::kInitialising:
      if (event == E::kPrepared) return S::kReady;
      return event == E::kHalt ? S::kSafe : state;
    case S::kReady:
      if (event == E::kInit) return S::kInitialising;
      if (event == E::kCommand) return S::kActive;
      return event == E::kHalt ? S::kSafe : state;
    case S::kActive:
      if (event == E::kCommandLost) return S::kHolding;
      return event == E::kHoldLimit || event == E::kHalt ? S::kSafe : state;
    case S::kHolding:
      if (event == E::kCommand) return S::kActive;
      if (event == E::kRecover) return S::kReady;
      return event == E::kHoldLimit || event == E::kHalt ? S::kSafe : state;
    case S::kSafe:
    case S::kFault:
      return event == E::kInit || event == E::kRecover ? S::kInitialising : state;
  }
  return S::kFault;
}

/// Whether commands are looked at, beyond being counted.
constexpr bool takesCommands(DriverState s) {
  return s == DriverState::kReady || s == DriverState::kActive || s == DriverState::kHolding;
}

/// Whether every actuator is in its safe behaviour, or on its way there, and stays so until somebody asks for more.
constexpr bool isSafe(DriverState s) {
  return s == DriverState::kOff || s == DriverState::kSafe || s == DriverState::kFault;
}

/// Whether set points are written and devices read every cycle. Traffic feeds the devices' bus watchdogs, so in every
/// other state the bus is left to fall silent.
constexpr bool servesDevices(DriverState s) {
  return takesCommands(s);
}

constexpr const char* name(DriverState s) {
  constexpr const char* kNames[] = {"off", "initialising", "ready", "active", "holding", "safe", "fault"};
  return kNames[static_cast<int>(s)];
}

}  // namespace sinew
