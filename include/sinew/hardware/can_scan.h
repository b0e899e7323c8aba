#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/can_frame.h"

namespace sinew {

/// Who speaks on a CAN bus, told from frames alone, without sending any.
///
/// A CANopen device shows by boot-up or heartbeat messages: one byte under 700 + node, a state of CiA 301. An ODrive
/// shows by heartbeats: 8 bytes under node * 32 + 1 with a state that an axis has, ten a second unless set otherwise.
/// Where an identifier may be either's, as 701, their length tells.
class CanScan {
 public:
  enum class Protocol { kCanOpen, kOdrive };

  struct Node {
    Protocol protocol = Protocol::kCanOpen;
    int number = 0;
    std::uint64_t heartbeats = 0;
    std::uint8_t state = 0;   ///< in the last heartbeat: NMT state (CiA 301), or state of the axis
    std::uint32_t error = 0;  ///< of an ODrive's axis
    bool booted = false;      ///< a CANopen boot-up message was among them
    double period = 0;        ///< s between the last two heartbeats; 0 before the second
  };

  struct Identifier {
    std::uint32_t id = 0;
    bool extended = false;
    std::uint64_t frames = 0;
    std::uint8_t size = 0;  ///< of the last frame
  };

  /// Takes a frame that came at `now`.
  void take(const CanFrame& frame, Time now);

  /// Devices found, by protocol and number.
  std::vector<Node> nodes() const;
  /// Identifiers that no device found uses, be they of a master or of devices of other protocols.
  std::vector<Identifier> unknown() const;
  std::uint64_t frames() const { return frames_; }

 private:
  struct Heard {
    Node node;
    Time last{};
  };
  void beat(Protocol protocol, int number, std::uint8_t state, std::uint32_t error, Time now);
  bool isOwned(const Identifier& identifier) const;

  std::map<std::pair<Protocol, int>, Heard> heard_;
  std::map<std::pair<bool, std::uint32_t>, Identifier> identifiers_;
  std::uint64_t frames_ = 0;
};

}  // namespace sinew
