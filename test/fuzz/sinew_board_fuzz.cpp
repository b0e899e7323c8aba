#include <sinew_board_link.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "firmware/board_bench.h"

namespace {

using namespace sinew;
using Bytes = std::vector<std::uint8_t>;

void require(bool property) {
  if (!property) std::abort();
}

/// A board under a script of packets, frames, noise, time and broken hardware. Whether it may do what it does is known
/// from its answers alone: what was configured, and when a set point was last accepted.
class Script {
 public:
  Script(const std::uint8_t* data, std::size_t size) : next_(data), end_(data + size) {
    sinew_serial_start(&serial_, &bench_.board, 5);
    sinew_can_start(&can_, &bench_.board, 5);
  }

  void run() {
    while (next_ != end_) {
      act(take());
      check();
    }
  }

 private:
  std::uint8_t take() { return next_ == end_ ? std::uint8_t{0} : *next_++; }

  void act(std::uint8_t what) {
    switch (what % 8) {
      case 0:
        return sendNoise();
      case 1:
        return sendPacket();
      case 2:
        return sendFrame();
      case 3:
        bench_.stop = take() % 2 != 0;
        break;
      case 4:
        bench_.chambers[take() % BoardBench::kChannels].broken = take() % 2 != 0;
        break;
      case 5:
        bench_.supply = static_cast<std::uint16_t>(9000 + 100 * (take() % 64));
        break;
      default:
        passTime(take());
    }
  }

  void sendByte(std::uint8_t byte) {
    std::uint8_t answer[SINEW_MAX_FRAME], packet[SINEW_MAX_FRAME];
    const std::size_t size = sinew_serial_take(&serial_, byte, answer);
    if (size == 0) return;
    require(size <= SINEW_MAX_FRAME && answer[size - 1] == 0);
    const std::size_t plain = sinew_unstuff(answer, size - 1, packet);
    require(sinew_packet_is_sound(packet, plain) && packet[0] == 5 && packet[1] >= 0x80);
    if (packet[1] != SINEW_CONFIGURATION) return;
    armed_ = true;
    timeout_ = static_cast<std::uint32_t>(packet[4] | packet[5] << 8);
    require(timeout_ >= 20 && timeout_ <= 5000);
  }

  void sendNoise() {
    for (int n = take() % 16; n > 0; --n) sendByte(take());
  }

  void sendPacket() {
    Bytes packet{5};
    for (int n = 3 + take() % 40; n > 0; --n) packet.push_back(take());
    const std::uint16_t crc = sinew_crc(packet.data(), packet.size());
    packet.push_back(static_cast<std::uint8_t>(crc));
    packet.push_back(static_cast<std::uint8_t>(crc >> 8));
    Bytes frame(packet.size() + 1);
    sinew_stuff(packet.data(), packet.size(), frame.data());
    for (const std::uint8_t byte : frame) sendByte(byte);
    sendByte(0);
  }

  void sendFrame() {
    sinew_can_frame frame{}, answers[SINEW_MAX_CAN_FRAMES];
    frame.id = SINEW_CAN_PREFIX | static_cast<std::uint32_t>(take() % 8) << 16 | 5u << 8 | take();
    frame.size = static_cast<std::uint8_t>(take() % 9);
    for (std::uint8_t& b : frame.data) b = take();
    const std::size_t count = sinew_can_take(&can_, &frame, answers);
    require(count <= SINEW_MAX_CAN_FRAMES);
    for (std::size_t i = 0; i < count; ++i) {
      require(answers[i].size <= 8);
      if ((answers[i].id >> 16 & 0xFF) != SINEW_CONFIGURATION || (answers[i].id & 0xFF) != SINEW_CAN_LAST) continue;
      armed_ = true;
      timeout_ = static_cast<std::uint32_t>(answers[i].data[0] | answers[i].data[1] << 8);
    }
  }

  void passTime(int ms) {
    for (int n = 0; n < ms; ++n) {
      bench_.pass(1);
      check();
    }
  }

  void check() {
    const sinew_state state = bench_.state();
    for (int i = 0; i < BoardBench::kChannels; ++i) {
      const int mode = state.channels[i].status & 3;
      require(mode == SINEW_VENT || armed_);
      if (mode == SINEW_REGULATE) {
        require(state.channels[i].faults == 0);
        require(state.age <= timeout_ + 1);
      }
      checkValve(i);
    }
  }

  void checkValve(int i) {
    const BoardBench::Chamber& c = bench_.chambers[i];
    if (c.path != SINEW_PATH_FILL) return;
    const std::int32_t maximum = bench_.board.channels[i].configuration.maximum;
    highest_maximum_ = std::max(highest_maximum_, maximum);
    require(armed_ && c.pressure <= highest_maximum_ + 1);
  }

  const std::uint8_t* next_;
  const std::uint8_t* end_;
  BoardBench bench_;
  sinew_serial_link serial_{};
  sinew_can_link can_{};
  bool armed_ = false;
  std::uint32_t timeout_ = 0;         // ms
  std::int32_t highest_maximum_ = 0;  // Pa gauge, ever in force while filling
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Script(data, std::min<std::size_t>(size, 400)).run();
  return 0;
}
