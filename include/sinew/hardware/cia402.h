#pragma once

#include <cstdint>

/// The state machine of a drive by CiA 402: what a statusword tells, and which controlword leads on.
namespace sinew::cia402 {

enum class State {
  kNotReady,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReaction,
  kFault
};

// Objects of the profile.
constexpr std::uint16_t kAbortConnection = 0x6007;  ///< what the drive does when the driver is gone
constexpr std::uint16_t kErrorCode = 0x603F;
constexpr std::uint16_t kControlword = 0x6040;
constexpr std::uint16_t kStatusword = 0x6041;
constexpr std::uint16_t kQuickStopOption = 0x605A;
constexpr std::uint16_t kMode = 0x6060;
constexpr std::uint16_t kModeDisplay = 0x6061;
constexpr std::uint16_t kPosition = 0x6064;
constexpr std::uint16_t kFollowingWindow = 0x6065;
constexpr std::uint16_t kMaxTorque = 0x6072;
constexpr std::uint16_t kMaxCurrent = 0x6073;
constexpr std::uint16_t kRatedCurrent = 0x6075;
constexpr std::uint16_t kRatedTorque = 0x6076;
constexpr std::uint16_t kTorque = 0x6077;
constexpr std::uint16_t kCurrent = 0x6078;
constexpr std::uint16_t kTarget = 0x607A;
constexpr std::uint16_t kMaxProfileVelocity = 0x607F;
constexpr std::uint16_t kMaxMotorSpeed = 0x6080;
constexpr std::uint16_t kHomingMethod = 0x6098;
constexpr std::uint16_t kHomingSpeeds = 0x6099;
constexpr std::uint16_t kHomingAcceleration = 0x609A;
constexpr std::uint16_t kInterpolationPeriod = 0x60C2;

constexpr std::uint16_t kProfile = 402;  ///< low half of a drive's device type, object 1000

// Modes of operation.
constexpr std::uint8_t kHoming = 6;
constexpr std::uint8_t kCyclicPosition = 8;

// Controlwords.
constexpr std::uint16_t kDisableVoltage = 0x0000;
constexpr std::uint16_t kQuickStop = 0x0002;
constexpr std::uint16_t kShutdown = 0x0006;
constexpr std::uint16_t kSwitchOn = 0x0007;
constexpr std::uint16_t kEnableOperation = 0x000F;
constexpr std::uint16_t kStartHoming = 0x001F;
constexpr std::uint16_t kFaultReset = 0x0080;  ///< acts when its bit rises

// Bits of the statusword beyond the state.
constexpr std::uint16_t kTargetReached = 1u << 10;
constexpr std::uint16_t kInternalLimit = 1u << 11;
constexpr std::uint16_t kHomingAttained = 1u << 12;  ///< in homing
constexpr std::uint16_t kHomingError = 1u << 13;     ///< in homing
constexpr std::uint16_t kFollowingError = 1u << 13;  ///< in cyclic position

// Option codes.
constexpr std::uint16_t kAbortByQuickStop = 3;     ///< of kAbortConnection
constexpr std::uint16_t kQuickStopAndDisable = 2;  ///< of kQuickStopOption: ramp, then switch on disabled
constexpr std::uint16_t kQuickStopAndStay = 6;     ///< of kQuickStopOption: ramp, then hold

State calcState(std::uint16_t statusword);
const char* describe(State state);

/// The controlword that takes a drive in `state` one step closer to operation enabled. In a fault it alternates by
/// `last`, the controlword sent before, because a fault is reset by the edge; where the drive moves on by itself it is
/// one that changes nothing.
std::uint16_t calcControlword(State state, std::uint16_t last);

/// The fault bits (ActuatorFault) that an error code (object 603F, or of an emergency) stands for.
std::uint32_t calcFault(std::uint16_t error_code);

}  // namespace sinew::cia402
