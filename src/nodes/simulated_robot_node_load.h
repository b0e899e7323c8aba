#pragma once

#include <atomic>
#include <chrono>
#include <ctime>

namespace sinew {

/// How much of a processor core one thread takes.
class ThreadLoad {
 public:
  /// To be called by the thread itself, once in each of its periods.
  void update() {
    timespec used{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    used_.store(static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec));
  }

  /// Share of a core [1] since the last call. One reader.
  double takeShare() {
    const double used = used_.load();
    const auto now = std::chrono::steady_clock::now();
    const double share = (used - last_used_) / std::chrono::duration<double>(now - last_time_).count();
    last_used_ = used;
    last_time_ = now;
    return share;
  }

 private:
  std::atomic<double> used_{0};  // s of the processor
  double last_used_ = 0;
  std::chrono::steady_clock::time_point last_time_ = std::chrono::steady_clock::now();
};

}  // namespace sinew
