#include "control_mode.h"

#include <chrono>
#include <thread>

namespace sinew {

Mode ControlMode::grant() {
  const Mode mode = wanted_.load(std::memory_order_acquire);
  granted_.store(mode, std::memory_order_release);
  return mode;
}

void ControlMode::disable(const char* reason) {
  disabled_reason_.store(reason, std::memory_order_release);
  Mode expected = Mode::kControlling;
  wanted_.compare_exchange_strong(expected, Mode::kFollowing, std::memory_order_acq_rel);
}

void ControlMode::park() {
  wanted_.store(Mode::kParked, std::memory_order_release);
  waitUntilParked(true);
}

void ControlMode::release(Mode mode, const char* reason) {
  disabled_reason_.store(reason, std::memory_order_release);
  wanted_.store(mode, std::memory_order_release);
  waitUntilParked(false);
}

void ControlMode::waitUntilParked(bool parked) const {
  while ((granted_.load(std::memory_order_acquire) == Mode::kParked) != parked) {
    std::this_thread::sleep_for(std::chrono::duration<double>(period_ / 4));
  }
}

}  // namespace sinew
