#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

#include "real_time.h"

namespace sinew {

/// What a loop that does nothing but sleep reaches at the same rate, priority and time: the yardstick of a controller's
/// deadlines. Records from `start` on.
class ControlLoop {
 public:
  explicit ControlLoop(double rate, std::size_t capacity = 1000000)
      : rate_(rate), capacity_(capacity), thread_([this] { run(); }) {}
  ~ControlLoop() { stop(); }
  ControlLoop(const ControlLoop&) = delete;
  ControlLoop& operator=(const ControlLoop&) = delete;

  void start() { recording_ = true; }
  void stop() {
    running_ = false;
    if (thread_.joinable()) thread_.join();
  }

  // After `stop`.
  const std::vector<double>& periods() const { return periods_; }    ///< s between two awakenings
  const std::vector<double>& lateness() const { return lateness_; }  ///< s, of each
  /// Periods left out, and awakenings so late that `work` [s] does not end within the period.
  std::size_t countMisses(double work) const {
    std::size_t misses = skipped_;
    for (const double late : lateness_) misses += late + work > 1 / rate_;
    return misses;
  }

 private:
  void run() {
    periods_.reserve(capacity_);
    lateness_.reserve(capacity_);
    raisePriority(kCyclePriority);
    PeriodicWakeUp wake_up(1 / rate_);
    wake_up.wait();
    for (double last = steadyNow(); running_;) {
      const std::uint64_t skipped = wake_up.skipped();
      wake_up.wait();
      const double now = steadyNow();
      if (recording_ && periods_.size() < capacity_) {
        periods_.push_back(now - last);
        lateness_.push_back(now - wake_up.scheduled());
        skipped_ += wake_up.skipped() - skipped;
      }
      last = now;
    }
  }

  double rate_;  // Hz
  std::size_t capacity_;
  std::atomic<bool> running_{true}, recording_{false};
  std::vector<double> periods_, lateness_;  // s
  std::size_t skipped_ = 0;
  std::thread thread_;
};

}  // namespace sinew
