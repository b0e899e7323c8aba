// Any frame: what is read of it lies within the frame, and agrees with what its bytes say by CiA 301.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "sinew/hardware/canopen_messages.h"

namespace {

using namespace sinew;

constexpr std::uint8_t kNode = 5;

void require(bool holds) {
  if (!holds) std::abort();
}

void checkReply(const CanFrame& frame) {
  canopen::SdoReply reply;
  if (!canopen::readSdoReply(frame, kNode, reply)) return;
  require(frame.id == 0x580 + kNode && frame.size == 8 && !frame.extended && !frame.remote);
  const unsigned specifier = frame.data[0] >> 5;
  require(specifier <= 4);
  using Kind = canopen::SdoReply::Kind;
  if (reply.kind == Kind::kUpload) require(specifier == 2 && reply.size >= 1 && reply.size <= 4);
  if (reply.kind == Kind::kUploadSegment) require(specifier == 0 && reply.size <= canopen::kSegmentSize);
  if (reply.kind == Kind::kUpload) require(std::memcmp(reply.data.data(), &frame.data[4], reply.size) == 0);
  if (reply.kind == Kind::kUploadSegment) require(std::memcmp(reply.data.data(), &frame.data[1], reply.size) == 0);
  if (reply.kind == Kind::kAbort) require(std::strlen(canopen::describeAbort(reply.abort_code)) > 0);
  require(reply.object.index == (frame.data[1] | frame.data[2] << 8) && reply.object.subindex == frame.data[3]);
}

void checkWords(const CanFrame& frame) {
  canopen::Emergency emergency;
  if (canopen::readEmergency(frame, kNode, emergency)) {
    require(frame.id == 0x080 + kNode && frame.size == 8);
    require(emergency.code == (frame.data[0] | frame.data[1] << 8) && emergency.vendor[4] == frame.data[7]);
    require(std::strlen(canopen::describeEmergency(emergency.code)) > 0);
  }
  canopen::NmtState state{};
  if (canopen::readHeartbeat(frame, kNode, state))
    require(frame.size == 1 && static_cast<std::uint8_t>(state) == frame.data[0]);
}

// Requests say what went into them.
void checkRequests(const CanFrame& frame) {
  const canopen::ObjectAddress object{static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8), frame.data[3]};
  const std::size_t expedited = 1 + frame.data[0] % canopen::kExpeditedSize;
  const CanFrame whole = canopen::makeSdoDownload(kNode, object, &frame.data[4], expedited);
  require(whole.size == 8 && (whole.data[0] & 0xE3) == 0x23 && 4u - (whole.data[0] >> 2 & 3u) == expedited);
  require(std::memcmp(&whole.data[4], &frame.data[4], expedited) == 0);
  const std::size_t segment = 1 + frame.data[0] % canopen::kSegmentSize;
  const CanFrame part = canopen::makeSdoDownloadSegment(kNode, true, false, &frame.data[1], segment);
  require((part.data[0] & 0xF1) == 0x10 && 7u - (part.data[0] >> 1 & 7u) == segment);
  std::uint8_t bytes[4];
  const std::uint32_t value = canopen::loadNumber(&frame.data[4], 4);
  canopen::storeNumber(value, 4, bytes);
  require(std::memcmp(bytes, &frame.data[4], 4) == 0);
  require(static_cast<std::uint32_t>(canopen::loadSigned(bytes, 4)) == value);
}

}  // namespace

// Steps of 12 bytes: three of the identifier and flags, the size, and eight of data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::uint32_t kIds[] = {0x080, 0x180, 0x580, 0x700};
  for (std::size_t at = 0; at + 12 <= size; at += 12) {
    CanFrame frame;
    frame.id = kIds[data[at] % 4] + data[at + 1] % 8;
    frame.extended = data[at + 2] == 0xFF;
    frame.remote = data[at + 2] == 0xFE;
    frame.size = data[at + 3] < 128 ? std::uint8_t{8} : static_cast<std::uint8_t>(data[at + 3] % 9);
    std::copy_n(data + at + 4, 8, frame.data.begin());
    checkReply(frame);
    checkWords(frame);
    checkRequests(frame);
  }
  return 0;
}
