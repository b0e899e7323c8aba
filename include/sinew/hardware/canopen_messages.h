#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sinew/hardware/can_frame.h"

/// The frames of CiA 301 as a driver writes and reads them. Numbers go over the line with their lowest byte first.
/// Readers take frames of any content: false means that the frame is not what they look for, or malformed.
namespace sinew::canopen {

constexpr std::uint8_t kMaxNode = 127;

// Identifiers of the predefined connection set; those of one node have its number added.
constexpr std::uint32_t kNmtId = 0x000;
constexpr std::uint32_t kSyncId = 0x080;
constexpr std::uint32_t kEmergencyId = 0x080;
constexpr std::uint32_t kTpdoId = 0x180;  ///< of TPDO 1, from the node; the next ones follow by 0x100
constexpr std::uint32_t kRpdoId = 0x200;  ///< of RPDO 1, to the node
constexpr std::uint32_t kSdoReplyId = 0x580;
constexpr std::uint32_t kSdoRequestId = 0x600;
constexpr std::uint32_t kHeartbeatId = 0x700;
constexpr std::uint32_t kPdoIdStep = 0x100;

/// `size` (1 to 4) bytes of a number; negative ones as their two's complement.
void storeNumber(std::uint32_t value, std::size_t size, std::uint8_t* to);
std::uint32_t loadNumber(const std::uint8_t* from, std::size_t size);
std::int32_t loadSigned(const std::uint8_t* from, std::size_t size);

/// An entry of a node's object dictionary.
struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
};
inline bool operator==(const ObjectAddress& a, const ObjectAddress& b) {
  return a.index == b.index && a.subindex == b.subindex;
}

/// What a PDO's mapping object holds for one entry of `bytes` bytes.
constexpr std::uint32_t calcMapping(ObjectAddress object, std::size_t bytes) {
  return static_cast<std::uint32_t>(object.index) << 16 | static_cast<std::uint32_t>(object.subindex) << 8 |
         static_cast<std::uint32_t>(8 * bytes);
}

// --- Network management ---

enum class NmtCommand : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82
};
enum class NmtState : std::uint8_t { kBootUp = 0x00, kStopped = 0x04, kOperational = 0x05, kPreOperational = 0x7F };

CanFrame makeNmt(NmtCommand command, std::uint8_t node);
CanFrame makeSync();
CanFrame makeHeartbeat(std::uint8_t node, NmtState state);
bool readHeartbeat(const CanFrame& frame, std::uint8_t node, NmtState& state);

// --- Emergencies ---

struct Emergency {
  std::uint16_t code = 0;  ///< 0: the error is gone
  std::uint8_t error_register = 0;
  std::array<std::uint8_t, 5> vendor{};
};
bool readEmergency(const CanFrame& frame, std::uint8_t node, Emergency& emergency);
/// The code's class in words.
const char* describeEmergency(std::uint16_t code);

// --- Service data objects, the client's side ---

enum SdoAbort : std::uint32_t {
  kAbortToggle = 0x05030000,
  kAbortTimeout = 0x05040000,
  kAbortCommand = 0x05040001,
  kAbortMemory = 0x05040005,
  kAbortReadOnly = 0x06010002,
  kAbortNoObject = 0x06020000,
  kAbortLength = 0x06070010,
  kAbortNoSubindex = 0x06090011
};
const char* describeAbort(std::uint32_t code);

constexpr std::size_t kSegmentSize = 7;
constexpr std::size_t kExpeditedSize = 4;

CanFrame makeSdoUpload(std::uint8_t node, ObjectAddress object);
CanFrame makeSdoUploadSegment(std::uint8_t node, bool toggle);
/// `size`: 1 to kExpeditedSize.
CanFrame makeSdoDownload(std::uint8_t node, ObjectAddress object, const std::uint8_t* data, std::size_t size);
/// Announces `size` bytes to follow in segments.
CanFrame makeSdoDownloadStart(std::uint8_t node, ObjectAddress object, std::size_t size);
/// `size`: 1 to kSegmentSize.
CanFrame makeSdoDownloadSegment(std::uint8_t node, bool toggle, bool last, const std::uint8_t* data, std::size_t size);
CanFrame makeSdoAbort(std::uint8_t node, ObjectAddress object, std::uint32_t code);

struct SdoReply {
  enum class Kind {
    kUpload,           ///< the object's data, `size` bytes
    kUploadStart,      ///< the data follow in segments; `size` bytes where `sized`
    kUploadSegment,    ///< `size` bytes of them
    kDownload,         ///< taken, or: the segments may come
    kDownloadSegment,  ///< taken
    kAbort             ///< refused, with `abort_code`
  };
  Kind kind = Kind::kAbort;
  ObjectAddress object;  ///< not with segments
  bool toggle = false;   ///< with segments
  bool last = false;     ///< of kUploadSegment
  bool sized = false;
  std::uint32_t size = 0;
  std::uint32_t abort_code = 0;
  std::array<std::uint8_t, kSegmentSize> data{};
};
bool readSdoReply(const CanFrame& frame, std::uint8_t node, SdoReply& reply);

}  // namespace sinew::canopen
