#include "sinew/hardware/cia402.h"

#include "sinew/hardware/actuator_reading.h"

namespace sinew::cia402 {

// CiA 402-2, "Statusword": bits 0 to 3, 5 and 6; bit 5 does not count where quick stop makes no difference.
State calcState(std::uint16_t statusword) {
  switch (statusword & 0x4F) {
    case 0x00:
      return State::kNotReady;
    case 0x40:
      return State::kSwitchOnDisabled;
    case 0x0F:
      return State::kFaultReaction;
    case 0x08:
      return State::kFault;
    default:
      break;
  }
  switch (statusword & 0x6F) {
    case 0x21:
      return State::kReadyToSwitchOn;
    case 0x23:
      return State::kSwitchedOn;
    case 0x27:
      return State::kOperationEnabled;
    case 0x07:
      return State::kQuickStopActive;
    default:
      return State::kNotReady;
  }
}

const char* describe(State state) {
  switch (state) {
    case State::kSwitchOnDisabled:
      return "switch on disabled";
    case State::kReadyToSwitchOn:
      return "ready to switch on";
    case State::kSwitchedOn:
      return "switched on";
    case State::kOperationEnabled:
      return "operation enabled";
    case State::kQuickStopActive:
      return "quick stop active";
    case State::kFaultReaction:
      return "fault reaction active";
    case State::kFault:
      return "fault";
    default:
      return "not ready to switch on";
  }
}

std::uint16_t calcControlword(State state, std::uint16_t last) {
  switch (state) {
    case State::kFault:
      return last == kDisableVoltage ? kFaultReset : kDisableVoltage;
    case State::kSwitchOnDisabled:
      return kShutdown;
    case State::kReadyToSwitchOn:
      return kSwitchOn;
    case State::kSwitchedOn:
    case State::kOperationEnabled:
    case State::kQuickStopActive:
      return kEnableOperation;
    default:
      return kDisableVoltage;
  }
}

std::uint32_t calcFault(std::uint16_t error_code) {
  if (error_code == 0) return 0;
  if (error_code == 0x8130) return kFaultWatchdog;
  switch (error_code >> 8) {
    case 0x73:
      return kFaultEncoder;
    case 0x83:
      return kFaultOverload;
    case 0x84:
    case 0x85:
    case 0x86:
      return kFaultFollowing;
    default:
      break;
  }
  // 312x mains, 322x link and 332x output undervoltage.
  const bool undervoltage = error_code >> 12 == 3 && (error_code & 0xF0) == 0x20;
  switch (error_code >> 12) {
    case 2:
      return kFaultOverload;
    case 3:
      return undervoltage ? kFaultVoltage | kFaultUndervolted : kFaultVoltage;
    case 4:
      return kFaultOverheated;
    case 5:
    case 6:
      return kFaultElectrical;
    default:
      return kFaultDevice;
  }
}

}  // namespace sinew::cia402
