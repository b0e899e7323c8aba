#pragma once

#include <cstdint>
#include <string>

#include "sinew/hardware/can_frame.h"

namespace sinew {

/// The messages of ODrive's CAN Simple protocol, after the ODrive documentation, "CAN Protocol". An identifier is the
/// node's number times 32 plus the command's; everything is little-endian; positions are turns of the motor.
enum class OdriveCommand : std::uint8_t {
  kGetVersion = 0x00,
  kHeartbeat = 0x01,
  kGetError = 0x03,
  kRxSdo = 0x04,
  kTxSdo = 0x05,
  kSetAxisState = 0x07,
  kGetEncoderEstimates = 0x09,
  kSetControllerMode = 0x0B,
  kSetInputPos = 0x0C,
  kSetLimits = 0x0F,
  kSetTrajVelLimit = 0x11,
  kSetTrajAccelLimits = 0x12,
  kGetIq = 0x14,
  kGetTemperature = 0x15,
  kGetBusVoltageCurrent = 0x17,
  kClearErrors = 0x18
};

constexpr int kMaxOdriveNode = 62;  // 63 stands for a node without a number

enum class OdriveState : std::uint8_t { kIdle = 1, kClosedLoop = 8 };
enum class OdriveInput : std::uint32_t { kPassThrough = 1, kTrapezoidal = 5 };
/// Firmware 0.5 runs on ODrive 3.x, 0.6 on ODrive S1, Pro and Micro; their error bits differ.
enum class OdriveFirmware { k05, k06 };

struct OdriveVersion {
  std::uint8_t protocol = 0;
  std::uint8_t major = 0, minor = 0, revision = 0;  ///< of the firmware
};
struct OdriveHeartbeat {
  std::uint32_t error = 0;  ///< bits of the firmware's axis errors
  std::uint8_t state = 0;   ///< OdriveState, or one of those that calibrate
};
struct OdriveError {
  std::uint32_t active = 0;
  std::uint32_t disarm_reason = 0;
};
/// Two numbers, as most messages carry: position and velocity, set point and measurement, ...
struct OdrivePair {
  float first = 0, second = 0;
};
/// A parameter's value, of `size` (1 to 4) bytes as its type has.
struct OdriveSdo {
  std::uint16_t endpoint = 0;
  std::uint8_t size = 4;
  std::uint32_t value = 0;
};

// To the device. `node` is 0 .. kMaxOdriveNode.

/// Asks for a message that the device has.
CanFrame makeOdriveRequest(int node, OdriveCommand command);
CanFrame makeOdriveAxisState(int node, OdriveState state);
/// Position control, with `input` between the set point and the controller.
CanFrame makeOdrivePositionMode(int node, OdriveInput input);
/// `position` in turns; no velocity or torque is fed forward.
CanFrame makeOdriveInputPos(int node, float position);
/// turn/s and A
CanFrame makeOdriveLimits(int node, float velocity, float current);
CanFrame makeOdriveTrajVelLimit(int node, float velocity);         ///< turn/s
CanFrame makeOdriveTrajAccelLimits(int node, float acceleration);  ///< turn/s2, to speed up and to brake
CanFrame makeOdriveClearErrors(int node);
/// Reads or writes the parameter behind an endpoint, whose number is that of flat_endpoints.json of the very firmware.
CanFrame makeOdriveSdoRead(int node, std::uint16_t endpoint);
CanFrame makeOdriveSdoWrite(int node, OdriveSdo sdo);

// From the device. Each returns false when the frame cannot be that message: wrong length, or a number that is none.

bool decodeOdrive(const CanFrame& frame, OdriveVersion& version);
bool decodeOdrive(const CanFrame& frame, OdriveHeartbeat& heartbeat);
bool decodeOdrive(const CanFrame& frame, OdriveError& error);
bool decodeOdrive(const CanFrame& frame, OdrivePair& pair);
bool decodeOdrive(const CanFrame& frame, OdriveSdo& sdo);

inline int odriveNode(const CanFrame& frame) {
  return static_cast<int>(frame.id >> 5);
}
inline OdriveCommand odriveCommand(const CanFrame& frame) {
  return static_cast<OdriveCommand>(frame.id & 0x1F);
}

/// ActuatorFault bits that an axis error means.
std::uint32_t calcOdriveFaults(OdriveFirmware firmware, std::uint32_t error);
/// The watchdog's bit among a firmware's axis errors.
std::uint32_t odriveWatchdogError(OdriveFirmware firmware);
/// An axis error in the firmware's own words: "0x01000000 (watchdog timer expired)".
std::string describeOdriveError(OdriveFirmware firmware, std::uint32_t error);

}  // namespace sinew
