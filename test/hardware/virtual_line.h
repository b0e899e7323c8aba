#pragma once

#include <vector>

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// The master's end of a line to simulated devices on a clock of its own: waiting for bytes moves that clock, and the
/// devices' mechanics with it. `Bus` has receive, transmit, nextDue and step.
template <typename Bus>
class VirtualLine : public ByteStream {
 public:
  explicit VirtualLine(Bus& bus) : bus_(bus) {}

  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) override {
    if (!plugged_) return {StreamStatus::kClosed, 0};
    const Time deadline = now_ + timeout;
    advanceTo(bus_.nextDue() > deadline ? deadline : bus_.nextDue());
    const std::size_t count = bus_.transmit(data, capacity, now_);
    return {count > 0 ? StreamStatus::kOk : StreamStatus::kTimeout, count};
  }

  StreamResult write(const std::uint8_t* data, std::size_t size, Duration) override {
    if (!plugged_) return {StreamStatus::kClosed, 0};
    last_written_.assign(data, data + size);
    bus_.receive(data, size, now_);
    return {StreamStatus::kOk, size};
  }

  Time now() const override { return now_; }

  /// Lets time pass up to `t`; earlier times change nothing.
  void advanceTo(Time t) {
    if (t <= now_) return;
    bus_.step(seconds(t - now_));
    now_ = t;
  }
  void setPlugged(bool plugged) { plugged_ = plugged; }
  const std::vector<std::uint8_t>& lastWritten() const { return last_written_; }

 private:
  Bus& bus_;
  Time now_{std::chrono::seconds(1)};
  bool plugged_ = true;
  std::vector<std::uint8_t> last_written_;
};

}  // namespace sinew
