#include "sinew/hardware/dynamixel_packet.h"

#include <algorithm>
#include <cstring>

namespace sinew {
namespace {

constexpr std::uint8_t kHeader[] = {0xFF, 0xFF, 0xFD, 0x00};
constexpr std::size_t kHeaderSize = sizeof kHeader;
constexpr std::size_t kPreambleSize = 7;  // header, id, length
constexpr std::size_t kCrcSize = 2;
constexpr std::size_t kMinLength = 3;  // instruction and CRC

std::array<std::uint16_t, 256> makeCrcTable() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < table.size(); ++i) {
    unsigned crc = i << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000u) != 0 ? (crc << 1) ^ 0x8005u : crc << 1;
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}

bool isPossibleId(std::uint8_t id) {
  return id <= kMaxServoId || id == kBroadcastId;
}

bool endsStuffable(const std::uint8_t* end, std::size_t size) {
  return size >= 3 && end[-3] == 0xFF && end[-2] == 0xFF && end[-1] == 0xFD;
}

}  // namespace

std::uint16_t calcCrc(const std::uint8_t* data, std::size_t size, std::uint16_t crc) {
  static const std::array<std::uint16_t, 256> kTable = makeCrcTable();
  for (std::size_t i = 0; i < size; ++i) {
    const unsigned index = (static_cast<unsigned>(crc) >> 8) ^ data[i];
    crc = static_cast<std::uint16_t>((static_cast<unsigned>(crc) << 8) ^ kTable[index]);
  }
  return crc;
}

void appendPacket(std::uint8_t id, Instruction instruction, const std::uint8_t* parameters, std::size_t size,
                  std::vector<std::uint8_t>& out) {
  const std::size_t start = out.size();
  out.insert(out.end(), kHeader, kHeader + kHeaderSize);
  out.insert(out.end(), {id, 0, 0, static_cast<std::uint8_t>(instruction)});
  std::size_t run = 0;  // bytes since the last stuffed one
  for (std::size_t i = 0; i < size; ++i) {
    out.push_back(parameters[i]);
    if (!endsStuffable(out.data() + out.size(), ++run)) continue;
    out.push_back(0xFD);
    run = 0;
  }
  const std::size_t length = out.size() - start - kPreambleSize + kCrcSize;
  out[start + 5] = static_cast<std::uint8_t>(length);
  out[start + 6] = static_cast<std::uint8_t>(length >> 8);
  const std::uint16_t crc = calcCrc(out.data() + start, out.size() - start);
  out.push_back(static_cast<std::uint8_t>(crc));
  out.push_back(static_cast<std::uint8_t>(crc >> 8));
}

PacketReader::PacketReader() : buffer_(2 * kMaxFrame), plain_(kMaxFrame) {}

void PacketReader::setMaxFrame(std::size_t size) {
  max_frame_ = std::min(size, kMaxFrame);
}

void PacketReader::put(const std::uint8_t* data, std::size_t size) {
  const std::size_t fits = std::min(size, capacity());
  std::copy(data, data + fits, space());
  take(fits);
  rejects_.noise += size - fits;
  skipped_ += size - fits;
}

void PacketReader::drop(std::size_t bytes) {
  begin_ += bytes;
  skipped_ += bytes;
}

void PacketReader::compact() {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), buffer_.begin() + static_cast<std::ptrdiff_t>(end_),
            buffer_.begin());
  end_ -= begin_;
  begin_ = 0;
}

std::size_t PacketReader::clear() {
  const std::size_t left = end_ - begin_;
  rejects_.noise += left;
  skipped_ += left;
  begin_ = end_ = 0;
  return left;
}

bool PacketReader::next(InstructionView& packet) {
  if (begin_ > 0) compact();
  for (;; drop(1)) {
    const std::uint8_t* p = buffer_.data() + begin_;
    const std::size_t available = end_ - begin_;
    if (!std::equal(p, p + std::min(available, kHeaderSize), kHeader)) {
      ++rejects_.noise;
      continue;
    }
    if (available < kPreambleSize) return false;
    const std::size_t length = static_cast<std::size_t>(p[5] | p[6] << 8);
    const std::size_t frame = kPreambleSize + length;
    if (!isPossibleId(p[4]) || length < kMinLength || frame > max_frame_) {
      ++rejects_.header;
      continue;
    }
    if (available < frame) return false;
    const std::uint16_t crc = calcCrc(p, frame - kCrcSize);
    if (p[frame - 2] != (crc & 0xFF) || p[frame - 1] != crc >> 8) {
      ++rejects_.crc;
      continue;
    }
    packet.id = p[4];
    packet.instruction = static_cast<Instruction>(p[kPreambleSize]);
    packet.frame = p;
    packet.frame_size = frame;
    if (!unstuff(packet)) {
      ++rejects_.stuffing;
      continue;
    }
    begin_ += frame;
    return true;
  }
}

// The joint answer to a fast sync read (a status packet from the broadcast id) is the one packet without byte stuffing.
bool PacketReader::unstuff(InstructionView& packet) {
  const bool stuffed = packet.instruction != Instruction::kStatus || packet.id != kBroadcastId;
  const std::uint8_t* in = packet.frame + kPreambleSize + 1;
  const std::uint8_t* end = packet.frame + packet.frame_size - kCrcSize;
  std::uint8_t* out = plain_.data();
  std::size_t run = 0;
  while (in != end) {
    *out++ = *in++;
    if (!stuffed || !endsStuffable(out, ++run)) continue;
    if (in == end || *in != 0xFD) return false;
    ++in;
    run = 0;
  }
  packet.parameters = plain_.data();
  packet.size = static_cast<std::size_t>(out - plain_.data());
  return true;
}

}  // namespace sinew
