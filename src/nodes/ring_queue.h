#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace sinew {

/// Carries values in order from one writer thread to one reader thread; neither ever waits. Slots are filled in place:
/// a T whose assignment does not allocate keeps the queue free of allocation.
template <typename T>
class RingQueue {
 public:
  RingQueue(std::size_t size, const T& initial) : slots_(size, initial) {}

  /// Writer: the slot to fill before `push()`, which holds an older value; null where the reader is that far behind.
  T* back() {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    return end - begin_.load(std::memory_order_acquire) < slots_.size() ? &slots_[end % slots_.size()] : nullptr;
  }
  void push() { end_.store(end_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  /// Reader: the oldest value, until `pop()`; null where there is none.
  const T* front() const {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    return begin != end_.load(std::memory_order_acquire) ? &slots_[begin % slots_.size()] : nullptr;
  }
  void pop() { begin_.store(begin_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  std::vector<T> slots_;
  std::atomic<std::size_t> begin_{0}, end_{0};
};

}  // namespace sinew
