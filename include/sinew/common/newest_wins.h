#pragma once

#include <array>
#include <atomic>

namespace sinew {

/// Hands the newest value from one writer thread to one reader thread; neither ever waits. Three slots: one belongs to
/// the writer, one to the reader, and the third is swapped through an atomic index. Values are assigned in place, so a
/// T whose assignment does not allocate keeps the exchange free of allocation.
template <typename T>
class NewestWins {
 public:
  explicit NewestWins(const T& initial = T()) : slots_{initial, initial, initial} {}

  /// Writer: the slot to fill before `publish()`. Holds an older value.
  T& back() { return slots_[write_]; }

  /// Writer: makes `back()` the newest value.
  void publish() { write_ = middle_.exchange(write_ | kFresh, std::memory_order_acq_rel) & kIndex; }

  void write(const T& value) {
    back() = value;
    publish();
  }

  /// Reader: takes the newest value; returns whether it is newer than the one read before.
  bool update() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    read_ = middle_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// Reader: the value taken by the last `update()`.
  const T& front() const { return slots_[read_]; }

 private:
  static constexpr unsigned kIndex = 3;
  static constexpr unsigned kFresh = 4;
  std::array<T, 3> slots_;
  unsigned write_ = 0;
  std::atomic<unsigned> middle_{1};
  unsigned read_ = 2;
};

}  // namespace sinew
