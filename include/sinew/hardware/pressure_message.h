#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sinew/hardware/can_frame.h"

namespace sinew {

// Messages of the pressure board protocol, version 1 (docs/pressure_board_protocol.md), as the host sees them: requests
// are encoded, answers decoded, for a serial line and for a CAN bus.

constexpr std::uint8_t kPressureProtocolVersion = 1;
constexpr int kMaxPressureChannels = 16;
constexpr int kMinPressureAddress = 1, kMaxPressureAddress = 247;
constexpr std::uint32_t kMaxPressureRamp = 10000000;  ///< Pa/s that a board can be told
constexpr std::uint16_t kNoSetPointAge = 0xFFFF;      ///< no set point yet, or one 65 s ago

enum class PressureType : std::uint8_t {
  kHello = 0x01,
  kConfigure = 0x02,
  kSetPoints = 0x03,
  kReadState = 0x04,
  kClearFaults = 0x05,
  kBounds = 0x06,  ///< CAN only: limit and ramp of set points
  kIdentity = 0x81,
  kConfiguration = 0x82,
  kState = 0x84,
  kError = 0x8F
};

enum class PressureReason : std::uint8_t {
  kAccepted = 0,
  kUnknownType = 1,
  kWrongLength = 2,
  kWrongVersion = 3,
  kWrongCount = 4,
  kOutOfRange = 5,
  kNotArmed = 6,
  kStale = 7,
  kBusy = 8
};

enum class PressureMode : std::uint8_t { kVent = 0, kRegulate = 1, kSeal = 2 };

/// Fault bits of a channel, latched by the board.
enum PressureChannelFault : std::uint8_t {
  kChannelSensor = 0x01,
  kChannelOverpressure = 0x02,
  kChannelTimeout = 0x04,
  kChannelStop = 0x08,
  kChannelSupply = 0x10,
  kChannelTemperature = 0x20,
  kChannelSource = 0x40
};

constexpr std::uint8_t kBoardArmed = 0x01, kBoardPump = 0x02, kBoardStop = 0x04;  ///< flags of a board's state

struct PressureIdentity {
  std::uint8_t version = 0;  ///< of the protocol
  std::uint8_t firmware_major = 0, firmware_minor = 0;
  std::uint8_t channels = 0;
  std::uint32_t serial_number = 0;
  std::int32_t range_min = 0, range_max = 0;  ///< Pa gauge
};

struct PressureChannelConfiguration {
  std::int32_t maximum = 0;  ///< Pa gauge
  std::uint32_t ramp = 1;    ///< Pa/s
  PressureMode on_timeout = PressureMode::kVent;

  bool operator==(const PressureChannelConfiguration& o) const {
    return maximum == o.maximum && ramp == o.ramp && on_timeout == o.on_timeout;
  }
};

struct PressureConfiguration {
  std::uint16_t timeout = 0;  ///< ms
  std::uint8_t count = 0;
  std::array<PressureChannelConfiguration, kMaxPressureChannels> channels{};

  bool operator==(const PressureConfiguration& o) const {
    return timeout == o.timeout && count == o.count && count <= kMaxPressureChannels &&
           std::equal(channels.begin(), channels.begin() + count, o.channels.begin());
  }
};

struct PressureSetPoint {
  PressureMode mode = PressureMode::kVent;
  std::int32_t pressure = 0;  ///< Pa gauge
  std::int32_t limit = 0;     ///< Pa gauge
  std::uint32_t ramp = 1;     ///< Pa/s
};

struct PressureChannelState {
  std::int32_t pressure = 0;  ///< Pa gauge
  std::uint8_t status = 0;    ///< mode in the two lowest bits, then which valve is open
  std::uint8_t faults = 0;    ///< PressureChannelFault
};

struct PressureState {
  std::uint32_t uptime = 0;      ///< ms
  std::uint16_t supply = 0;      ///< mV
  std::int16_t temperature = 0;  ///< 0.1 degC
  std::uint16_t age = kNoSetPointAge;
  std::uint16_t accepted = 0;  ///< sequence of the newest accepted set point
  std::uint8_t flags = 0;
  PressureReason refusal = PressureReason::kAccepted;
  std::uint8_t count = 0;
  std::array<PressureChannelState, kMaxPressureChannels> channels{};
};

/// What a board is asked; which members count depends on the type.
struct PressureRequest {
  PressureType type = PressureType::kReadState;
  std::uint16_t sequence = 0;
  PressureConfiguration configuration;
  std::uint8_t count = 0;  ///< of set points
  std::array<PressureSetPoint, kMaxPressureChannels> set_points{};
  std::uint16_t mask = 0;  ///< channels whose faults are cleared
};

/// What a board answers; which members count depends on the type.
struct PressureAnswer {
  std::uint8_t address = 0;
  PressureType type = PressureType::kError;
  std::uint16_t sequence = 0;  ///< of the request; on CAN only a state's
  PressureIdentity identity;
  PressureConfiguration configuration;
  PressureState state;
  PressureType refused = PressureType::kError;        ///< with kError: the type of the request ...
  PressureReason reason = PressureReason::kAccepted;  ///< ... and what is wrong with it
};

/// CRC-16/IBM-3740: polynomial 0x1021, initial 0xFFFF, not reflected, no final inversion.
std::uint16_t calcPressureCrc(const std::uint8_t* data, std::size_t size);

/// Bytes on a serial line of a request or an answer with `channels` channels, its ending zero included.
std::size_t pressureFrameSize(PressureType type, int channels);

/// Appends a request's frame, ending zero included, to `out`.
void appendPressureRequest(std::uint8_t address, const PressureRequest& request, std::vector<std::uint8_t>& out);

/// Reads an answer from an unstuffed packet, address to CRC. False when it is damaged or is no answer of the protocol.
bool decodePressureAnswer(const std::uint8_t* packet, std::size_t size, PressureAnswer& answer);

/// Appends a request's CAN frames to `out`.
void appendPressureFrames(std::uint8_t address, const PressureRequest& request, std::vector<CanFrame>& out);

/// Puts the answers of one board together from its CAN frames, which come in ascending order of their index.
class PressureFrameReader {
 public:
  explicit PressureFrameReader(std::uint8_t address) : address_(address) {}

  enum class Progress { kForeign, kDamaged, kPart, kWhole };
  /// kForeign: not from this board. kDamaged: of an impossible size or index, or the last frame of an answer that
  /// misses others. kWhole: `answer()` is complete.
  Progress take(const CanFrame& frame);
  const PressureAnswer& answer() const { return answer_; }
  /// Forgets the parts of answers that never became whole.
  void clear();

 private:
  Progress takeIdentity(std::uint8_t index, const CanFrame& frame);
  Progress takeConfiguration(std::uint8_t index, const CanFrame& frame);
  Progress takeState(std::uint8_t index, const CanFrame& frame);
  Progress finish(PressureType type, std::uint32_t parts, bool whole);

  std::uint8_t address_;
  PressureAnswer answer_;
  std::uint32_t parts_ = 0;  // of the answer under way: a bit per channel, and kBoardPart
  std::uint16_t sequence_ = 0;
  PressureType type_ = PressureType::kError;
};

}  // namespace sinew
