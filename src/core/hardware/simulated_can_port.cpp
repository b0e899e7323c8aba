#include "sinew/hardware/simulated_can_port.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr auto kTick = std::chrono::milliseconds(1);  // within which devices may begin to send by themselves

}  // namespace

StreamStatus SimulatedCanPort::send(const CanFrame& frame, Duration) {
  if (!plugged_) return StreamStatus::kClosed;
  bus_.receive(frame, now_);
  return StreamStatus::kOk;
}

StreamStatus SimulatedCanPort::receive(CanFrame& frame, Duration timeout) {
  const Time deadline = now_ + timeout;
  while (plugged_) {
    if (bus_.transmit(frame, now_)) return StreamStatus::kOk;
    if (now_ >= deadline) return StreamStatus::kTimeout;
    now_ = std::min({deadline, std::max(now_, bus_.nextDue()), now_ + kTick});
  }
  return StreamStatus::kClosed;
}

void SimulatedCanPort::advanceTo(Time t) {
  now_ = std::max(now_, t);
  bus_.update(now_);
}

}  // namespace sinew
