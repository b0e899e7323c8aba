#pragma once

#include <array>
#include <atomic>

#include "sinew/hardware/command_gate.h"

namespace sinew {

/// Carries commands from the thread that receives them to the bus thread; neither ever waits. The bus thread takes all
/// that have come and follows the newest it accepts, so that every refused one is still counted by its reason, which a
/// slot for the newest alone would lose.
class CommandQueue {
 public:
  /// Receiving thread: false when the bus thread is so far behind that there is no room.
  bool push(const Command& command) {
    const unsigned end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == kSize) return false;
    slots_[end % kSize] = command;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// Bus thread: the oldest one waiting; false when there is none.
  bool pop(Command& command) {
    const unsigned begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    command = slots_[begin % kSize];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

 private:
  static constexpr unsigned kSize = 64;
  std::array<Command, kSize> slots_{};
  std::atomic<unsigned> begin_{0}, end_{0};
};

}  // namespace sinew
