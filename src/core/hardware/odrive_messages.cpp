#include "sinew/hardware/odrive_messages.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>

#include "sinew/hardware/actuator_reading.h"

namespace sinew {
namespace {

constexpr std::uint32_t kPositionControl = 3;
constexpr std::uint8_t kSdoRead = 0, kSdoWrite = 1;

struct ErrorBit {
  std::uint32_t bit, fault;
  const char* name;
};

// ODrive documentation 0.6, API reference, ODrive.Error.
constexpr ErrorBit kErrors06[] = {{0x00000001, kFaultOff, "initializing"},
                                  {0x00000002, kFaultElectrical, "system level"},
                                  {0x00000004, kFaultElectrical, "timing error"},
                                  {0x00000008, kFaultEncoder, "missing estimate"},
                                  {0x00000010, kFaultDevice, "bad config"},
                                  {0x00000020, kFaultElectrical, "drv fault"},
                                  {0x00000040, kFaultDevice, "missing input"},
                                  {0x00000100, kFaultVoltage, "dc bus over voltage"},
                                  {0x00000200, kFaultVoltage | kFaultUndervolted, "dc bus under voltage"},
                                  {0x00000400, kFaultOverload, "dc bus over current"},
                                  {0x00000800, kFaultOverload, "dc bus over regen current"},
                                  {0x00001000, kFaultOverload, "current limit violation"},
                                  {0x00002000, kFaultOverheated, "motor over temp"},
                                  {0x00004000, kFaultOverheated, "inverter over temp"},
                                  {0x00008000, kFaultFollowing, "velocity limit violation"},
                                  {0x00010000, kFaultFollowing, "position limit violation"},
                                  {0x01000000, kFaultWatchdog, "watchdog timer expired"},
                                  {0x02000000, kFaultDevice, "estop requested"},
                                  {0x04000000, kFaultEncoder, "spinout detected"},
                                  {0x08000000, kFaultElectrical, "brake resistor disarmed"},
                                  {0x10000000, kFaultSensor, "thermistor disconnected"},
                                  {0x40000000, kFaultEncoder, "calibration error"}};

// ODrive documentation 0.5, API reference, ODrive.Axis.Error.
constexpr ErrorBit kErrors05[] = {{0x00000001, kFaultDevice, "invalid state"},
                                  {0x00000040, kFaultElectrical, "motor failed"},
                                  {0x00000080, kFaultEncoder, "sensorless estimator failed"},
                                  {0x00000100, kFaultEncoder, "encoder failed"},
                                  {0x00000200, kFaultFollowing, "controller failed"},
                                  {0x00000800, kFaultWatchdog, "watchdog timer expired"},
                                  {0x00001000, kFaultDevice, "min endstop pressed"},
                                  {0x00002000, kFaultDevice, "max endstop pressed"},
                                  {0x00004000, kFaultDevice, "estop requested"},
                                  {0x00020000, kFaultDevice, "homing without endstop"},
                                  {0x00040000, kFaultOverheated, "over temp"},
                                  {0x00080000, kFaultEncoder, "unknown position"}};

struct ErrorTable {
  const ErrorBit* first;
  const ErrorBit* last;
  const ErrorBit* begin() const { return first; }
  const ErrorBit* end() const { return last; }
};

ErrorTable errorsOf(OdriveFirmware firmware) {
  if (firmware == OdriveFirmware::k05) return {std::begin(kErrors05), std::end(kErrors05)};
  return {std::begin(kErrors06), std::end(kErrors06)};
}

CanFrame makeFrame(int node, OdriveCommand command, std::uint8_t size) {
  CanFrame frame;
  frame.id = static_cast<std::uint32_t>(node) << 5 | static_cast<std::uint32_t>(command);
  frame.size = size;
  return frame;
}

void put(CanFrame& frame, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) frame.data[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

void put(CanFrame& frame, std::size_t at, float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  put(frame, at, bits);
}

std::uint32_t word(const CanFrame& frame, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(frame.data[at + i]) << (8 * i);
  return value;
}

float number(const CanFrame& frame, std::size_t at) {
  const std::uint32_t bits = word(frame, at);
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

bool isFull(const CanFrame& frame) {
  return !frame.remote && frame.size == 8;
}

}  // namespace

CanFrame makeOdriveRequest(int node, OdriveCommand command) {
  CanFrame frame = makeFrame(node, command, 0);
  frame.remote = true;
  return frame;
}

CanFrame makeOdriveAxisState(int node, OdriveState state) {
  CanFrame frame = makeFrame(node, OdriveCommand::kSetAxisState, 4);
  put(frame, 0, static_cast<std::uint32_t>(state));
  return frame;
}

CanFrame makeOdrivePositionMode(int node, OdriveInput input) {
  CanFrame frame = makeFrame(node, OdriveCommand::kSetControllerMode, 8);
  put(frame, 0, kPositionControl);
  put(frame, 4, static_cast<std::uint32_t>(input));
  return frame;
}

CanFrame makeOdriveInputPos(int node, float position) {
  CanFrame frame = makeFrame(node, OdriveCommand::kSetInputPos, 8);
  put(frame, 0, position);
  return frame;
}

CanFrame makeOdriveLimits(int node, float velocity, float current) {
  CanFrame frame = makeFrame(node, OdriveCommand::kSetLimits, 8);
  put(frame, 0, velocity);
  put(frame, 4, current);
  return frame;
}

CanFrame makeOdriveTrajVelLimit(int node, float velocity) {
  CanFrame frame = makeFrame(node, OdriveCommand::kSetTrajVelLimit, 4);
  put(frame, 0, velocity);
  return frame;
}

CanFrame makeOdriveTrajAccelLimits(int node, float acceleration) {
  CanFrame frame = makeFrame(node, OdriveCommand::kSetTrajAccelLimits, 8);
  put(frame, 0, acceleration);
  put(frame, 4, acceleration);
  return frame;
}

CanFrame makeOdriveClearErrors(int node) {
  return makeFrame(node, OdriveCommand::kClearErrors, 8);
}

CanFrame makeOdriveSdoRead(int node, std::uint16_t endpoint) {
  CanFrame frame = makeOdriveSdoWrite(node, {endpoint, 0, 0});
  frame.data[0] = kSdoRead;
  return frame;
}

CanFrame makeOdriveSdoWrite(int node, OdriveSdo sdo) {
  CanFrame frame = makeFrame(node, OdriveCommand::kRxSdo, static_cast<std::uint8_t>(4 + sdo.size));
  frame.data[0] = kSdoWrite;
  frame.data[1] = static_cast<std::uint8_t>(sdo.endpoint);
  frame.data[2] = static_cast<std::uint8_t>(sdo.endpoint >> 8);
  for (std::size_t i = 0; i < sdo.size; ++i) frame.data[4 + i] = static_cast<std::uint8_t>(sdo.value >> (8 * i));
  return frame;
}

bool decodeOdrive(const CanFrame& frame, OdriveVersion& version) {
  version = {frame.data[0], frame.data[4], frame.data[5], frame.data[6]};
  return isFull(frame);
}

bool decodeOdrive(const CanFrame& frame, OdriveHeartbeat& heartbeat) {
  heartbeat = {word(frame, 0), frame.data[4]};
  return isFull(frame);
}

bool decodeOdrive(const CanFrame& frame, OdriveError& error) {
  error = {word(frame, 0), word(frame, 4)};
  return isFull(frame);
}

bool decodeOdrive(const CanFrame& frame, OdrivePair& pair) {
  pair = {number(frame, 0), number(frame, 4)};
  return isFull(frame) && std::isfinite(pair.first) && std::isfinite(pair.second);
}

bool decodeOdrive(const CanFrame& frame, OdriveSdo& sdo) {
  if (frame.remote || frame.size < 5 || frame.size > 8) return false;
  sdo.endpoint = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
  sdo.size = static_cast<std::uint8_t>(frame.size - 4);
  sdo.value = 0;
  for (std::size_t i = 0; i < sdo.size; ++i) sdo.value |= static_cast<std::uint32_t>(frame.data[4 + i]) << (8 * i);
  return true;
}

std::uint32_t calcOdriveFaults(OdriveFirmware firmware, std::uint32_t error) {
  std::uint32_t faults = 0;
  for (const ErrorBit& e : errorsOf(firmware)) {
    if ((error & e.bit) != 0) faults |= e.fault;
    error &= ~e.bit;
  }
  return error != 0 ? faults | kFaultDevice : faults;
}

std::uint32_t odriveWatchdogError(OdriveFirmware firmware) {
  return firmware == OdriveFirmware::k05 ? 0x800 : 0x1000000;
}

std::string describeOdriveError(OdriveFirmware firmware, std::uint32_t error) {
  char digits[16];
  std::snprintf(digits, sizeof digits, "0x%08X", error);
  std::string names;
  for (const ErrorBit& e : errorsOf(firmware))
    if ((error & e.bit) != 0) names += (names.empty() ? "" : ", ") + std::string(e.name);
  return digits + (names.empty() ? "" : " (" + names + ")");
}

}  // namespace sinew
