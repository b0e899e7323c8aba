#include "sinew/hardware/canopen_messages.h"

#include <algorithm>

namespace sinew::canopen {
namespace {

// Command specifiers: the upper three bits of an SDO's first byte.
constexpr unsigned kClientDownloadSegment = 0, kClientDownload = 1, kClientUpload = 2, kClientUploadSegment = 3;
constexpr unsigned kServerUploadSegment = 0, kServerDownloadSegment = 1, kServerUpload = 2, kServerDownload = 3;
constexpr unsigned kSpecifierAbort = 4;
// Bits of that byte.
constexpr unsigned kToggle = 0x10, kExpedited = 0x02, kSized = 0x01, kLast = 0x01;

CanFrame makeFrame(std::uint32_t id, std::uint8_t size) {
  CanFrame frame;
  frame.id = id;
  frame.size = size;
  return frame;
}

bool isFrom(const CanFrame& frame, std::uint32_t id, std::size_t size) {
  return frame.id == id && !frame.extended && !frame.remote && frame.size == size;
}

CanFrame makeSdo(std::uint8_t node, unsigned command) {
  CanFrame frame = makeFrame(kSdoRequestId + node, 8);
  frame.data[0] = static_cast<std::uint8_t>(command);
  return frame;
}

CanFrame makeSdo(std::uint8_t node, unsigned command, ObjectAddress object) {
  CanFrame frame = makeSdo(node, command);
  storeNumber(object.index, 2, &frame.data[1]);
  frame.data[3] = object.subindex;
  return frame;
}

struct Words {
  std::uint32_t code;
  const char* words;
};

template <std::size_t N>
const char* find(const Words (&table)[N], std::uint32_t code) {
  const auto* found = std::find_if(std::begin(table), std::end(table), [&](const Words& w) { return w.code == code; });
  return found == std::end(table) ? nullptr : found->words;
}

// CiA 301, "SDO abort codes".
constexpr Words kAborts[] = {
    {kAbortToggle, "the toggle bit did not alternate"},
    {kAbortTimeout, "the transfer timed out"},
    {kAbortCommand, "unknown command specifier"},
    {0x05040002, "invalid block size"},
    {0x05040003, "invalid sequence number"},
    {0x05040004, "wrong checksum of a block"},
    {kAbortMemory, "out of memory"},
    {0x06010000, "this access to the object is not supported"},
    {0x06010001, "the object cannot be read"},
    {kAbortReadOnly, "the object cannot be written"},
    {kAbortNoObject, "no such object"},
    {0x06040041, "the object cannot be mapped to a PDO"},
    {0x06040042, "the mapped objects are longer than a PDO"},
    {0x06040043, "the parameters do not fit together"},
    {0x06040047, "the device's inside does not fit together"},
    {0x06060000, "hardware error"},
    {kAbortLength, "wrong length for the object's type"},
    {0x06070012, "too long for the object's type"},
    {0x06070013, "too short for the object's type"},
    {kAbortNoSubindex, "no such subindex"},
    {0x06090030, "the value is out of range"},
    {0x06090031, "the value is too high"},
    {0x06090032, "the value is too low"},
    {0x06090036, "the maximum is below the minimum"},
    {0x060A0023, "a resource is not available"},
    {0x08000000, "general error"},
    {0x08000020, "the data cannot be stored"},
    {0x08000021, "the data cannot be stored because of local control"},
    {0x08000022, "the data cannot be stored in the device's present state"},
    {0x08000023, "there is no object dictionary"},
    {0x08000024, "there are no data"},
};

// CiA 301, "Emergency error codes", and those that CiA 402 adds for drives.
constexpr Words kEmergencyCodes[] = {
    {0x0000, "no error"},
    {0x2310, "overcurrent"},
    {0x3210, "overvoltage"},
    {0x3220, "undervoltage"},
    {0x4210, "the electronics are too hot"},
    {0x4310, "the drive is too hot"},
    {0x7305, "incremental encoder"},
    {0x8130, "heartbeat or life guard missing"},
    {0x8611, "following error"},
    {0x8612, "limit of the reference"},
};
constexpr Words kEmergencyClasses[] = {
    {0x00, "no error"},       {0x10, "generic error"},       {0x20, "current"},
    {0x30, "voltage"},        {0x40, "temperature"},         {0x50, "hardware"},
    {0x60, "software"},       {0x70, "additional module"},   {0x80, "monitoring"},
    {0x90, "external error"}, {0xF0, "additional function"}, {0xA0, "device's own"},
    {0xB0, "device's own"},   {0xC0, "device's own"},        {0xD0, "device's own"},
    {0xE0, "device's own"},
};

}  // namespace

void storeNumber(std::uint32_t value, std::size_t size, std::uint8_t* to) {
  for (std::size_t i = 0; i < size; ++i) to[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint32_t loadNumber(const std::uint8_t* from, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= static_cast<std::uint32_t>(from[i]) << (8 * i);
  return value;
}

std::int32_t loadSigned(const std::uint8_t* from, std::size_t size) {
  const std::uint32_t value = loadNumber(from, size);
  const bool negative = (from[size - 1] & 0x80) != 0;
  const std::uint32_t above = size < 4 ? ~0u << (8 * size) : 0;
  return static_cast<std::int32_t>(negative ? value | above : value);
}

CanFrame makeNmt(NmtCommand command, std::uint8_t node) {
  CanFrame frame = makeFrame(kNmtId, 2);
  frame.data[0] = static_cast<std::uint8_t>(command);
  frame.data[1] = node;
  return frame;
}

CanFrame makeSync() {
  return makeFrame(kSyncId, 0);
}

CanFrame makeHeartbeat(std::uint8_t node, NmtState state) {
  CanFrame frame = makeFrame(kHeartbeatId + node, 1);
  frame.data[0] = static_cast<std::uint8_t>(state);
  return frame;
}

bool readHeartbeat(const CanFrame& frame, std::uint8_t node, NmtState& state) {
  if (!isFrom(frame, kHeartbeatId + node, 1)) return false;
  const auto said = static_cast<NmtState>(frame.data[0]);
  if (said != NmtState::kBootUp && said != NmtState::kStopped && said != NmtState::kOperational &&
      said != NmtState::kPreOperational)
    return false;
  state = said;
  return true;
}

bool readEmergency(const CanFrame& frame, std::uint8_t node, Emergency& emergency) {
  if (!isFrom(frame, kEmergencyId + node, 8)) return false;
  emergency.code = static_cast<std::uint16_t>(loadNumber(frame.data.data(), 2));
  emergency.error_register = frame.data[2];
  std::copy(frame.data.begin() + 3, frame.data.end(), emergency.vendor.begin());
  return true;
}

const char* describeEmergency(std::uint16_t code) {
  if (const char* words = find(kEmergencyCodes, code)) return words;
  const char* words = find(kEmergencyClasses, (code >> 8) & 0xF0u);
  return words == nullptr ? "unknown" : words;
}

const char* describeAbort(std::uint32_t code) {
  const char* words = find(kAborts, code);
  return words == nullptr ? "a reason of the device's own" : words;
}

CanFrame makeSdoUpload(std::uint8_t node, ObjectAddress object) {
  return makeSdo(node, kClientUpload << 5, object);
}

CanFrame makeSdoUploadSegment(std::uint8_t node, bool toggle) {
  return makeSdo(node, kClientUploadSegment << 5 | (toggle ? kToggle : 0u));
}

CanFrame makeSdoDownload(std::uint8_t node, ObjectAddress object, const std::uint8_t* data, std::size_t size) {
  const unsigned unused = static_cast<unsigned>(kExpeditedSize - size);
  CanFrame frame = makeSdo(node, kClientDownload << 5 | unused << 2 | kExpedited | kSized, object);
  std::copy(data, data + size, &frame.data[4]);
  return frame;
}

CanFrame makeSdoDownloadStart(std::uint8_t node, ObjectAddress object, std::size_t size) {
  CanFrame frame = makeSdo(node, kClientDownload << 5 | kSized, object);
  storeNumber(static_cast<std::uint32_t>(size), 4, &frame.data[4]);
  return frame;
}

CanFrame makeSdoDownloadSegment(std::uint8_t node, bool toggle, bool last, const std::uint8_t* data, std::size_t size) {
  const unsigned unused = static_cast<unsigned>(kSegmentSize - size);
  CanFrame frame =
      makeSdo(node, kClientDownloadSegment << 5 | (toggle ? kToggle : 0u) | unused << 1 | (last ? kLast : 0u));
  std::copy(data, data + size, &frame.data[1]);
  return frame;
}

CanFrame makeSdoAbort(std::uint8_t node, ObjectAddress object, std::uint32_t code) {
  CanFrame frame = makeSdo(node, kSpecifierAbort << 5, object);
  storeNumber(code, 4, &frame.data[4]);
  return frame;
}

bool readSdoReply(const CanFrame& frame, std::uint8_t node, SdoReply& reply) {
  if (!isFrom(frame, kSdoReplyId + node, 8)) return false;
  const unsigned command = frame.data[0];
  reply = SdoReply{};
  reply.object.index = static_cast<std::uint16_t>(loadNumber(&frame.data[1], 2));
  reply.object.subindex = frame.data[3];
  reply.toggle = (command & kToggle) != 0;
  switch (command >> 5) {
    case kServerUpload:
      reply.sized = (command & kSized) != 0;
      if ((command & kExpedited) != 0) {
        reply.kind = SdoReply::Kind::kUpload;
        reply.size = reply.sized ? 4 - (command >> 2 & 3u) : 4;
        std::copy_n(&frame.data[4], reply.size, reply.data.begin());
      } else {
        reply.kind = SdoReply::Kind::kUploadStart;
        reply.size = reply.sized ? loadNumber(&frame.data[4], 4) : 0;
      }
      return true;
    case kServerUploadSegment:
      reply.kind = SdoReply::Kind::kUploadSegment;
      reply.last = (command & kLast) != 0;
      reply.size = static_cast<std::uint32_t>(kSegmentSize - (command >> 1 & 7u));
      std::copy_n(&frame.data[1], reply.size, reply.data.begin());
      return true;
    case kServerDownload:
      reply.kind = SdoReply::Kind::kDownload;
      return true;
    case kServerDownloadSegment:
      reply.kind = SdoReply::Kind::kDownloadSegment;
      return true;
    case kSpecifierAbort:
      reply.kind = SdoReply::Kind::kAbort;
      reply.abort_code = loadNumber(&frame.data[4], 4);
      return true;
    default:
      return false;
  }
}

}  // namespace sinew::canopen
