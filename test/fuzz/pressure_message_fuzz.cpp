#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "sinew/hardware/cobs.h"
#include "sinew/hardware/pressure_message.h"

namespace {

using namespace sinew;
using Bytes = std::vector<std::uint8_t>;

void require(bool property) {
  if (!property) std::abort();
}

void checkAnswer(const PressureAnswer& a) {
  require(a.type == PressureType::kIdentity || a.type == PressureType::kConfiguration ||
          a.type == PressureType::kState || a.type == PressureType::kError);
  if (a.type == PressureType::kState) require(a.state.count <= kMaxPressureChannels);
  if (a.type != PressureType::kConfiguration) return;
  require(a.configuration.count <= kMaxPressureChannels);
  for (int i = 0; i < a.configuration.count; ++i)
    require(a.configuration.channels[static_cast<std::size_t>(i)].on_timeout <= PressureMode::kSeal);
}

// As it came, and with the CRC that it should have.
void checkPacket(Bytes packet) {
  PressureAnswer answer;
  if (decodePressureAnswer(packet.data(), packet.size(), answer)) checkAnswer(answer);
  const std::uint16_t crc = calcPressureCrc(packet.data(), packet.size());
  packet.push_back(static_cast<std::uint8_t>(crc));
  packet.push_back(static_cast<std::uint8_t>(crc >> 8));
  if (decodePressureAnswer(packet.data(), packet.size(), answer)) checkAnswer(answer);
}

// Ten bytes a frame: type, index, data.
void checkFrames(const Bytes& bytes) {
  PressureFrameReader reader(5);
  for (std::size_t i = 0; i + 10 <= bytes.size(); i += 10) {
    CanFrame frame;
    frame.extended = true;
    frame.id = 0x15000500u | static_cast<std::uint32_t>(bytes[i]) << 16 | bytes[i + 1];
    frame.size = 8;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(i) + 2, 8, frame.data.begin());
    if (bytes[i] == 0x8F) frame.size = 2;
    if (bytes[i] == 0x82 && bytes[i + 1] == 0xFF) frame.size = 5;
    const PressureFrameReader::Progress progress = reader.take(frame);
    require(progress != PressureFrameReader::Progress::kForeign || bytes[i] < 0x80);
    if (progress == PressureFrameReader::Progress::kWhole) checkAnswer(reader.answer());
  }
}

// A request of any content is a frame of the size foretold, without a zero but its last byte.
void checkRequest(const Bytes& bytes) {
  PressureRequest r;
  constexpr PressureType kTypes[] = {PressureType::kHello, PressureType::kConfigure, PressureType::kSetPoints,
                                     PressureType::kReadState, PressureType::kClearFaults};
  r.type = kTypes[bytes[0] % 5];
  r.sequence = r.mask = static_cast<std::uint16_t>(bytes[0] * 257);
  r.count = r.configuration.count = static_cast<std::uint8_t>(bytes[1] % (kMaxPressureChannels + 1));
  for (std::size_t i = 0; i < r.count; ++i) {
    const std::uint8_t b = bytes[(2 + i) % bytes.size()];
    r.set_points[i] = {PressureMode::kRegulate, b * 0x00808080, b << 16, b * 7919u};
    r.configuration.channels[i] = {b << 20, b * 65537u, PressureMode::kSeal};
  }
  Bytes frame;
  appendPressureRequest(bytes[0], r, frame);
  require(frame.size() == pressureFrameSize(r.type, r.count) && frame.back() == 0);
  require(std::count(frame.begin(), frame.end(), 0) == 1);
  Bytes packet;
  require(decodeCobs(frame.data(), frame.size() - 1, packet) && packet.size() + 2 == frame.size());
  std::vector<CanFrame> frames;
  appendPressureFrames(bytes[0], r, frames);
  for (const CanFrame& f : frames) require(f.size <= 8 && f.extended && f.id <= 0x1FFFFFFF);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes(data, data + size);
  checkPacket(bytes);
  checkFrames(bytes);
  if (size >= 2) checkRequest(bytes);
  return 0;
}
