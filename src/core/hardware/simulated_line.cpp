#include "sinew/hardware/simulated_line.h"

namespace sinew {

StreamResult SimulatedLine::read(std::uint8_t* data, std::size_t capacity, Duration timeout) {
  if (!plugged_) return {StreamStatus::kClosed, 0};
  const Time deadline = now_ + timeout;
  if (bus_.nextDue() > deadline) {
    now_ = deadline;
    return {StreamStatus::kTimeout, 0};
  }
  advanceTo(bus_.nextDue());
  const std::size_t count = bus_.transmit(data, capacity, now_);
  return {count > 0 ? StreamStatus::kOk : StreamStatus::kTimeout, count};
}

StreamResult SimulatedLine::write(const std::uint8_t* data, std::size_t size, Duration) {
  if (!plugged_) return {StreamStatus::kClosed, 0};
  bus_.receive(data, size, now_);
  return {StreamStatus::kOk, size};
}

}  // namespace sinew
