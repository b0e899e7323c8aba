// Any bytes from a Dynamixel line: what passes for a packet is one, comes back when it is written and read again, and
// is the same however the bytes arrive; nothing is lost from the account.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/dynamixel_packet.h"

namespace {

using namespace sinew;
using Bytes = std::vector<std::uint8_t>;

void require(bool property) {
  if (!property) std::abort();
}

struct Packet {
  std::uint8_t id;
  Instruction instruction;
  Bytes parameters;
  bool operator==(const Packet& o) const {
    return id == o.id && instruction == o.instruction && parameters == o.parameters;
  }
};

std::size_t drain(PacketReader& reader, std::vector<Packet>& packets) {
  std::size_t bytes = 0;
  InstructionView view;
  while (reader.next(view)) {
    require(view.frame_size <= PacketReader::kMaxFrame && view.size <= view.frame_size);
    packets.push_back({view.id, view.instruction, Bytes(view.parameters, view.parameters + view.size)});
    bytes += view.frame_size;
  }
  return bytes;
}

std::vector<Packet> readAll(const std::uint8_t* data, std::size_t size, std::size_t chunk) {
  PacketReader reader;
  std::vector<Packet> packets;
  std::size_t used = 0;
  for (std::size_t at = 0; at < size; at += chunk) {
    reader.put(data + at, std::min(chunk, size - at));
    used += drain(reader, packets);
  }
  require(used + reader.pending() + reader.skipped() == size);
  return packets;
}

void checkRoundTrip(const Packet& packet) {
  Bytes bytes;
  appendPacket(packet.id, packet.instruction, packet.parameters.data(), packet.parameters.size(), bytes);
  const std::vector<Packet> again = readAll(bytes.data(), bytes.size(), bytes.size());
  require(bytes.size() > PacketReader::kMaxFrame || (again.size() == 1 && again[0] == packet));
}

/// A line on which everything asked is answered by the same bytes.
class Echo : public ByteStream {
 public:
  Echo(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) override {
    const std::size_t count = std::min(capacity, size_ - at_);
    if (count > 0) std::memcpy(data, data_ + at_, count);
    at_ += count;
    if (count == 0) now_ += timeout;
    return {count > 0 ? StreamStatus::kOk : StreamStatus::kTimeout, count};
  }
  StreamResult write(const std::uint8_t*, std::size_t size, Duration) override {
    at_ = 0;
    return {StreamStatus::kOk, size};
  }
  Time now() const override { return now_; }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
  Time now_{};
};

void checkMaster(const std::uint8_t* data, std::size_t size) {
  Echo line(data, size);
  DynamixelBus bus(1000000, std::chrono::milliseconds(1));
  bus.attach(&line);
  std::int32_t value = 0;
  bus.read(1, servo_register::kPresentPosition, value);
  std::vector<SyncAnswer> answers(3);
  bus.syncRead(224, 14, {1, 2, 3}, answers);
  bus.setFastSyncRead(false);
  bus.syncRead(224, 14, {1, 2, 3}, answers);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > PacketReader::kMaxFrame) return 0;
  const std::vector<Packet> packets = readAll(data, size, std::max<std::size_t>(size, 1));
  require(packets == readAll(data, size, 1));
  for (const Packet& packet : packets) checkRoundTrip(packet);
  checkMaster(data, size);
  return 0;
}
