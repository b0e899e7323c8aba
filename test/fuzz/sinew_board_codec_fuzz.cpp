#include <sinew_board_codec.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

using Bytes = std::vector<std::uint8_t>;

void require(bool property) {
  if (!property) std::abort();
}

void checkStuffing(const Bytes& bytes) {
  Bytes plain(bytes.size() + 1);
  plain.resize(sinew_unstuff(bytes.data(), bytes.size(), plain.data()));
  require(plain.size() <= bytes.size());
  Bytes in_place = bytes;
  require(sinew_unstuff(in_place.data(), in_place.size(), in_place.data()) == plain.size());
  require(std::equal(plain.begin(), plain.end(), in_place.begin()));

  const std::size_t size = std::min<std::size_t>(bytes.size(), 254);
  Bytes stuffed(size + 1), back(size + 1);
  stuffed.resize(sinew_stuff(bytes.data(), size, stuffed.data()));
  require(std::count(stuffed.begin(), stuffed.end(), 0) == 0);
  back.resize(sinew_unstuff(stuffed.data(), stuffed.size(), back.data()));
  require(back.size() == size && std::equal(back.begin(), back.end(), bytes.begin()));
}

void checkRequest(Bytes packet) {
  const std::uint16_t crc = sinew_crc(packet.data(), packet.size());
  packet.push_back(static_cast<std::uint8_t>(crc));
  packet.push_back(static_cast<std::uint8_t>(crc >> 8));
  if (!sinew_packet_is_sound(packet.data(), packet.size())) {
    require(packet.size() < 6 || packet.size() > SINEW_MAX_PACKET);
    return;
  }
  sinew_request request{};
  if (sinew_decode_request(packet.data(), packet.size(), &request) != SINEW_ACCEPTED) return;
  require(request.type == packet[1] && request.type >= SINEW_HELLO && request.type <= SINEW_CLEAR_FAULTS);
  if (request.type == SINEW_CONFIGURE) require(request.as.configuration.count <= SINEW_MAX_CHANNELS);
  if (request.type == SINEW_SET_POINTS) require(request.as.set_points.count <= SINEW_MAX_CHANNELS);
}

void checkCan(const Bytes& bytes) {
  sinew_can_frame frame{};
  if (bytes.size() < 3) return;
  frame.id = SINEW_CAN_PREFIX | static_cast<std::uint32_t>(bytes[0]) << 16 | 5u << 8 | bytes[1];
  require(sinew_can_is_request(frame.id, 5) == (bytes[0] < 0x80));
  frame.size = static_cast<std::uint8_t>(bytes[2] % 9);
  std::copy_n(bytes.begin() + 3, std::min<std::size_t>(8, bytes.size() - 3), frame.data);
  sinew_can_request request{};
  if (sinew_can_decode(&frame, &request) != SINEW_ACCEPTED) return;
  require(request.type >= SINEW_HELLO && request.type <= SINEW_BOUNDS && request.index == bytes[1]);
}

// Any state that a board can be in fits its frame and its CAN frames.
void checkAnswer(const Bytes& bytes) {
  sinew_answer answer;
  std::memset(&answer, 0, sizeof answer);
  if (!bytes.empty()) std::memcpy(&answer, bytes.data(), std::min(bytes.size(), sizeof answer));
  constexpr std::uint8_t kTypes[] = {SINEW_IDENTITY, SINEW_CONFIGURATION, SINEW_STATE, SINEW_ERROR};
  answer.type = kTypes[answer.type % 4];
  if (answer.type == SINEW_CONFIGURATION)
    answer.as.configuration.count = static_cast<std::uint8_t>(answer.as.configuration.count % (SINEW_MAX_CHANNELS + 1));
  if (answer.type == SINEW_STATE)
    answer.as.state.count = static_cast<std::uint8_t>(answer.as.state.count % (SINEW_MAX_CHANNELS + 1));
  Bytes frame(SINEW_MAX_FRAME);
  frame.resize(sinew_encode_answer(&answer, frame.data()));
  require(std::count(frame.begin(), frame.end(), 0) == 1 && frame.back() == 0);
  Bytes packet(frame.size());
  packet.resize(sinew_unstuff(frame.data(), frame.size() - 1, packet.data()));
  require(sinew_packet_is_sound(packet.data(), packet.size()));
  sinew_can_frame frames[SINEW_MAX_CAN_FRAMES];
  require(sinew_can_encode(&answer, frames) <= SINEW_MAX_CAN_FRAMES);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes bytes(data, data + size);
  checkStuffing(bytes);
  checkRequest(bytes);
  checkCan(bytes);
  checkAnswer(bytes);
  return 0;
}
