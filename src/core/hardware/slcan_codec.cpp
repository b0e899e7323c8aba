#include "sinew/hardware/slcan_codec.h"

namespace sinew {
namespace {

constexpr std::uint8_t kReturn = '\r', kBell = '\a';
constexpr std::size_t kStandardDigits = 3, kExtendedDigits = 8, kStampDigits = 4;
constexpr std::uint32_t kStandardMax = 0x7FF, kExtendedMax = 0x1FFFFFFF;

void writeHex(std::uint32_t value, std::size_t digits, std::uint8_t* out) {
  for (std::size_t i = 0; i < digits; ++i)
    out[i] = static_cast<std::uint8_t>("0123456789ABCDEF"[value >> (4 * (digits - 1 - i)) & 0xF]);
}

// False when a digit is none.
bool readHex(const std::uint8_t* digits, std::size_t count, std::uint32_t& value) {
  value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const int c = digits[i];
    int digit = -1;
    if (c >= '0' && c <= '9') digit = c - '0';
    if (c >= 'A' && c <= 'F') digit = c - 'A' + 10;
    if (c >= 'a' && c <= 'f') digit = c - 'a' + 10;
    if (digit < 0) return false;
    value = value << 4 | static_cast<std::uint32_t>(digit);
  }
  return true;
}

bool isFrameType(std::uint8_t c) {
  return c == 't' || c == 'T' || c == 'r' || c == 'R';
}

bool isAnswer(std::uint8_t c) {
  return c == 'V' || c == 'v' || c == 'N' || c == 'F' || c == 'A';
}

}  // namespace

std::size_t encodeSlcan(const CanFrame& frame, std::uint8_t* out) {
  const std::size_t digits = frame.extended ? kExtendedDigits : kStandardDigits;
  const char type = frame.remote ? 'r' : 't';
  out[0] = static_cast<std::uint8_t>(frame.extended ? type - 'a' + 'A' : type);
  writeHex(frame.id, digits, out + 1);
  writeHex(frame.size, 1, out + 1 + digits);
  std::size_t size = digits + 2;
  for (std::size_t i = 0; i < frame.size && !frame.remote; ++i, size += 2) writeHex(frame.data[i], 2, out + size);
  out[size++] = kReturn;
  return size;
}

SlcanEvent SlcanDecoder::put(std::uint8_t byte) {
  if (byte == kReturn) return endLine();
  if (byte == kBell) {
    size_ = 0;
    too_long_ = false;
    return SlcanEvent::kError;
  }
  if (size_ == line_.size()) too_long_ = true;
  if (!too_long_) line_[size_++] = byte;
  return SlcanEvent::kNone;
}

SlcanEvent SlcanDecoder::endLine() {
  SlcanEvent event = SlcanEvent::kDamaged;
  if (size_ == 0 || (size_ == 1 && (line_[0] == 'z' || line_[0] == 'Z')))
    event = SlcanEvent::kOk;
  else if (!too_long_ && isFrameType(line_[0]) && readFrame())
    event = SlcanEvent::kFrame;
  else if (!too_long_ && isAnswer(line_[0]))
    event = SlcanEvent::kInfo;
  size_ = 0;
  too_long_ = false;
  return event;
}

bool SlcanDecoder::readFrame() {
  CanFrame frame;
  frame.extended = line_[0] == 'T' || line_[0] == 'R';
  frame.remote = line_[0] == 'r' || line_[0] == 'R';
  const std::size_t digits = frame.extended ? kExtendedDigits : kStandardDigits;
  std::uint32_t length = 0, byte = 0, stamp = 0;
  if (size_ < digits + 2 || !readHex(&line_[1], digits, frame.id) || !readHex(&line_[1 + digits], 1, length))
    return false;
  if (frame.id > (frame.extended ? kExtendedMax : kStandardMax) || length > frame.data.size()) return false;
  frame.size = static_cast<std::uint8_t>(length);
  std::size_t at = digits + 2;
  const std::size_t end = at + (frame.remote ? 0 : 2 * length);
  if (size_ != end && size_ != end + kStampDigits) return false;
  for (std::size_t i = 0; at < end; ++i, at += 2) {
    if (!readHex(&line_[at], 2, byte)) return false;
    frame.data[i] = static_cast<std::uint8_t>(byte);
  }
  if (!readHex(&line_[end], size_ - end, stamp)) return false;
  frame_ = frame;
  return true;
}

}  // namespace sinew
