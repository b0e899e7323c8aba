#include "sinew/hardware/pressure_message.h"

#include "sinew/hardware/cobs.h"

namespace sinew {
namespace {

constexpr std::size_t kHeaderSize = 4, kCrcSize = 2;
constexpr std::size_t kMaxPacket = 254;
constexpr std::uint32_t kCanPrefix = 0x15000000;
constexpr std::uint8_t kLast = 0xFF, kBoard = 0xFE;  // indices of frames that speak of no channel
constexpr std::uint32_t kBoardPart = 1u << kMaxPressureChannels;

/// Little-endian numbers into a range of bytes.
class Writer {
 public:
  explicit Writer(std::uint8_t* to) : to_(to) {}
  Writer& u8(unsigned value) {
    *to_++ = static_cast<std::uint8_t>(value);
    return *this;
  }
  Writer& u16(unsigned value) { return u8(value).u8(value >> 8); }
  Writer& u32(std::uint32_t value) { return u16(value).u16(value >> 16); }
  Writer& i32(std::int32_t value) { return u32(static_cast<std::uint32_t>(value)); }
  std::uint8_t* end() const { return to_; }

 private:
  std::uint8_t* to_;
};

/// Little-endian numbers out of bytes whose count was checked before.
class Reader {
 public:
  explicit Reader(const std::uint8_t* from) : from_(from) {}
  std::uint8_t u8() { return *from_++; }
  std::uint16_t u16() {
    const unsigned low = u8();
    return static_cast<std::uint16_t>(low | static_cast<unsigned>(u8()) << 8);
  }
  std::uint32_t u32() {
    const std::uint32_t low = u16();
    return low | static_cast<std::uint32_t>(u16()) << 16;
  }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }

 private:
  const std::uint8_t* from_;
};

unsigned number(PressureType type) {
  return static_cast<unsigned>(type);
}
unsigned number(PressureMode mode) {
  return static_cast<unsigned>(mode);
}

std::size_t payloadSize(PressureType type, std::size_t channels) {
  switch (type) {
    case PressureType::kHello:
      return 1;
    case PressureType::kConfigure:
    case PressureType::kConfiguration:
      return 3 + 9 * channels;
    case PressureType::kSetPoints:
      return 1 + 13 * channels;
    case PressureType::kClearFaults:
    case PressureType::kError:
      return 2;
    case PressureType::kIdentity:
      return 16;
    case PressureType::kState:
      return 15 + 6 * channels;
    case PressureType::kReadState:
    case PressureType::kBounds:
      return 0;
  }
  return 0;
}

bool toMode(std::uint8_t value, PressureMode& mode) {
  mode = static_cast<PressureMode>(value);
  return value <= number(PressureMode::kSeal);
}

std::uint8_t* writePayload(const PressureRequest& r, std::uint8_t* to) {
  Writer out(to);
  switch (r.type) {
    case PressureType::kHello:
      out.u8(kPressureProtocolVersion);
      break;
    case PressureType::kConfigure:
      out.u16(r.configuration.timeout).u8(r.configuration.count);
      for (std::size_t i = 0; i < r.configuration.count; ++i) {
        const PressureChannelConfiguration& c = r.configuration.channels[i];
        out.i32(c.maximum).u32(c.ramp).u8(number(c.on_timeout));
      }
      break;
    case PressureType::kSetPoints:
      out.u8(r.count);
      for (std::size_t i = 0; i < r.count; ++i) {
        const PressureSetPoint& s = r.set_points[i];
        out.u8(number(s.mode)).i32(s.pressure).i32(s.limit).u32(s.ramp);
      }
      break;
    case PressureType::kClearFaults:
      out.u16(r.mask);
      break;
    default:
      break;
  }
  return out.end();
}

bool readIdentity(Reader in, PressureIdentity& identity) {
  identity.version = in.u8();
  identity.firmware_major = in.u8();
  identity.firmware_minor = in.u8();
  identity.channels = in.u8();
  identity.serial_number = in.u32();
  identity.range_min = in.i32();
  identity.range_max = in.i32();
  return true;
}

bool readConfiguration(Reader in, PressureConfiguration& c) {
  c.timeout = in.u16();
  c.count = in.u8();
  for (std::size_t i = 0; i < c.count; ++i) {
    c.channels[i].maximum = in.i32();
    c.channels[i].ramp = in.u32();
    if (!toMode(in.u8(), c.channels[i].on_timeout)) return false;
  }
  return true;
}

bool readState(Reader in, PressureState& s) {
  s.uptime = in.u32();
  s.supply = in.u16();
  s.temperature = in.i16();
  s.age = in.u16();
  s.accepted = in.u16();
  s.flags = in.u8();
  s.refusal = static_cast<PressureReason>(in.u8());
  s.count = in.u8();
  for (std::size_t i = 0; i < s.count; ++i) {
    s.channels[i].pressure = in.i32();
    s.channels[i].status = in.u8();
    s.channels[i].faults = in.u8();
  }
  return true;
}

// Where a payload keeps its count of channels; 0 for a payload without channels.
std::size_t countOffset(PressureType type) {
  if (type == PressureType::kConfiguration) return 2;
  return type == PressureType::kState ? 14 : 0;
}

bool isAnswer(PressureType type) {
  return type == PressureType::kIdentity || type == PressureType::kConfiguration || type == PressureType::kState ||
         type == PressureType::kError;
}

bool hasRightSize(PressureType type, const std::uint8_t* payload, std::size_t size) {
  const std::size_t offset = countOffset(type);
  if (offset == 0) return size == payloadSize(type, 0);
  if (size <= offset || payload[offset] > kMaxPressureChannels) return false;
  return size == payloadSize(type, payload[offset]);
}

CanFrame makeFrame(std::uint8_t address, PressureType type, std::uint8_t index) {
  CanFrame frame;
  frame.id = kCanPrefix | number(type) << 16 | static_cast<std::uint32_t>(address) << 8 | index;
  frame.extended = true;
  return frame;
}

void appendConfigureFrames(std::uint8_t address, const PressureConfiguration& c, std::vector<CanFrame>& out) {
  unsigned seals = 0;
  for (std::uint8_t i = 0; i < c.count; ++i) {
    CanFrame frame = makeFrame(address, PressureType::kConfigure, i);
    frame.size = 8;
    Writer(frame.data.data()).i32(c.channels[i].maximum).u32(c.channels[i].ramp);
    out.push_back(frame);
    if (c.channels[i].on_timeout == PressureMode::kSeal) seals |= 1u << i;
  }
  CanFrame frame = makeFrame(address, PressureType::kConfigure, kLast);
  frame.size = 5;
  Writer(frame.data.data()).u16(c.timeout).u16(seals).u8(c.count);
  out.push_back(frame);
}

void appendBoundsFrames(std::uint8_t address, const PressureRequest& r, std::vector<CanFrame>& out) {
  for (std::uint8_t i = 0; i < r.count; ++i) {
    CanFrame frame = makeFrame(address, PressureType::kBounds, i);
    frame.size = 8;
    Writer(frame.data.data()).i32(r.set_points[i].limit).u32(r.set_points[i].ramp);
    out.push_back(frame);
  }
}

void appendSetPointFrames(std::uint8_t address, const PressureRequest& r, std::vector<CanFrame>& out) {
  for (std::uint8_t i = 0; i < r.count; ++i) {
    const PressureSetPoint& s = r.set_points[i];
    CanFrame frame = makeFrame(address, PressureType::kSetPoints, i);
    frame.size = 7;
    Writer(frame.data.data()).i32(s.pressure).u16(r.sequence).u8(number(s.mode));
    out.push_back(frame);
  }
}

}  // namespace

std::uint16_t calcPressureCrc(const std::uint8_t* data, std::size_t size) {
  unsigned crc = 0xFFFF;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= static_cast<unsigned>(data[i]) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000u) != 0 ? crc << 1 ^ 0x1021u : crc << 1;
    crc &= 0xFFFFu;
  }
  return static_cast<std::uint16_t>(crc);
}

std::size_t pressureFrameSize(PressureType type, int channels) {
  return kHeaderSize + payloadSize(type, static_cast<std::size_t>(channels)) + kCrcSize + 2;
}

void appendPressureRequest(std::uint8_t address, const PressureRequest& request, std::vector<std::uint8_t>& out) {
  std::array<std::uint8_t, kMaxPacket> packet;
  static_assert(kHeaderSize + 1 + 13 * kMaxPressureChannels + kCrcSize <= kMaxPacket, "one block of stuffing");
  std::uint8_t* payload = Writer(packet.data()).u8(address).u8(number(request.type)).u16(request.sequence).end();
  std::uint8_t* crc = writePayload(request, payload);
  const auto size = static_cast<std::size_t>(crc - packet.data());
  Writer(crc).u16(calcPressureCrc(packet.data(), size));
  appendCobs(packet.data(), size + kCrcSize, out);
  out.push_back(0);
}

bool decodePressureAnswer(const std::uint8_t* packet, std::size_t size, PressureAnswer& answer) {
  if (size < kHeaderSize + kCrcSize || size > kMaxPacket) return false;
  const std::uint8_t* payload = packet + kHeaderSize;
  const std::size_t length = size - kHeaderSize - kCrcSize;
  if (Reader(payload + length).u16() != calcPressureCrc(packet, size - kCrcSize)) return false;
  answer.address = packet[0];
  answer.type = static_cast<PressureType>(packet[1]);
  answer.sequence = Reader(packet + 2).u16();
  if (!isAnswer(answer.type) || !hasRightSize(answer.type, payload, length)) return false;
  switch (answer.type) {
    case PressureType::kIdentity:
      return readIdentity(Reader(payload), answer.identity);
    case PressureType::kConfiguration:
      return readConfiguration(Reader(payload), answer.configuration);
    case PressureType::kState:
      return readState(Reader(payload), answer.state);
    default:
      answer.refused = static_cast<PressureType>(payload[0]);
      answer.reason = static_cast<PressureReason>(payload[1]);
      return true;
  }
}

void appendPressureFrames(std::uint8_t address, const PressureRequest& r, std::vector<CanFrame>& out) {
  CanFrame frame = makeFrame(address, r.type, 0);
  Writer data(frame.data.data());
  switch (r.type) {
    case PressureType::kConfigure:
      return appendConfigureFrames(address, r.configuration, out);
    case PressureType::kSetPoints:
      return appendSetPointFrames(address, r, out);
    case PressureType::kBounds:
      return appendBoundsFrames(address, r, out);
    case PressureType::kHello:
      data.u8(kPressureProtocolVersion);
      break;
    case PressureType::kClearFaults:
      data.u16(r.sequence).u16(r.mask);
      break;
    default:
      data.u16(r.sequence);
  }
  frame.size = static_cast<std::uint8_t>(data.end() - frame.data.data());
  out.push_back(frame);
}

void PressureFrameReader::clear() {
  parts_ = 0;
  type_ = PressureType::kError;
}

PressureFrameReader::Progress PressureFrameReader::take(const CanFrame& frame) {
  const std::uint32_t from = kCanPrefix | static_cast<std::uint32_t>(address_) << 8;
  if (!frame.extended || (frame.id & 0x1F00FF00u) != from) return Progress::kForeign;
  const auto type = static_cast<PressureType>(frame.id >> 16 & 0xFF);
  if ((number(type) & 0x80u) == 0) return Progress::kForeign;
  if (frame.remote) return Progress::kDamaged;
  if (type != type_) parts_ = 0;
  type_ = type;
  const auto index = static_cast<std::uint8_t>(frame.id & 0xFF);
  switch (type) {
    case PressureType::kIdentity:
      return takeIdentity(index, frame);
    case PressureType::kConfiguration:
      return takeConfiguration(index, frame);
    case PressureType::kState:
      return takeState(index, frame);
    case PressureType::kError:
      if (frame.size != 2 || index != kLast) return Progress::kDamaged;
      answer_.refused = static_cast<PressureType>(frame.data[0]);
      answer_.reason = static_cast<PressureReason>(frame.data[1]);
      return finish(type, 0, true);
    default:
      return Progress::kDamaged;
  }
}

// Closes an answer whose frames were `parts`.
PressureFrameReader::Progress PressureFrameReader::finish(PressureType type, std::uint32_t parts, bool whole) {
  const bool all = whole && parts_ == parts;
  clear();
  answer_.address = address_;
  answer_.type = type;
  return all ? Progress::kWhole : Progress::kDamaged;
}

PressureFrameReader::Progress PressureFrameReader::takeIdentity(std::uint8_t index, const CanFrame& frame) {
  if (frame.size != 8 || (index != 0 && index != kLast)) return Progress::kDamaged;
  Reader in(frame.data.data());
  PressureIdentity& identity = answer_.identity;
  if (index == kLast) {
    identity.range_min = in.i32();
    identity.range_max = in.i32();
    return finish(PressureType::kIdentity, 1, true);
  }
  identity.version = in.u8();
  identity.firmware_major = in.u8();
  identity.firmware_minor = in.u8();
  identity.channels = in.u8();
  identity.serial_number = in.u32();
  parts_ = 1;
  return Progress::kPart;
}

PressureFrameReader::Progress PressureFrameReader::takeConfiguration(std::uint8_t index, const CanFrame& frame) {
  if (frame.size != (index == kLast ? 5 : 8) || (index != kLast && index >= kMaxPressureChannels))
    return Progress::kDamaged;
  Reader in(frame.data.data());
  PressureConfiguration& c = answer_.configuration;
  if (index < kMaxPressureChannels) {
    c.channels[index].maximum = in.i32();
    c.channels[index].ramp = in.u32();
    parts_ |= 1u << index;
    return Progress::kPart;
  }
  c.timeout = in.u16();
  const unsigned seals = in.u16();
  c.count = in.u8();
  for (std::size_t i = 0; i < c.channels.size(); ++i)
    c.channels[i].on_timeout = (seals >> i & 1u) != 0 ? PressureMode::kSeal : PressureMode::kVent;
  const bool possible = c.count <= kMaxPressureChannels;
  return finish(PressureType::kConfiguration, possible ? (1u << c.count) - 1 : 0, possible);
}

PressureFrameReader::Progress PressureFrameReader::takeState(std::uint8_t index, const CanFrame& frame) {
  if (frame.size != 8 || (index < kBoard && index >= kMaxPressureChannels)) return Progress::kDamaged;
  Reader in(frame.data.data());
  PressureState& s = answer_.state;
  if (index == kBoard) {
    s.uptime = in.u32();
    s.supply = in.u16();
    s.temperature = in.i16();
    parts_ |= kBoardPart;
    return Progress::kPart;
  }
  Reader tail(frame.data.data() + 6);
  const std::uint16_t sequence = tail.u16();
  if (sequence != sequence_) parts_ = 0;
  sequence_ = sequence;
  if (index == kLast) {
    s.age = in.u16();
    s.accepted = in.u16();
    s.flags = in.u8();
    s.refusal = static_cast<PressureReason>(in.u8());
    s.count = 0;
    while (s.count < kMaxPressureChannels && (parts_ >> s.count & 1u) != 0) ++s.count;
    answer_.sequence = sequence;
    return finish(PressureType::kState, ((1u << s.count) - 1) | kBoardPart, true);
  }
  s.channels[index].pressure = in.i32();
  s.channels[index].status = in.u8();
  s.channels[index].faults = in.u8();
  parts_ |= 1u << index;
  return Progress::kPart;
}

}  // namespace sinew
