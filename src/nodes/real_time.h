#pragma once

#include <cstdint>
#include <string>

namespace sinew {

/// s on the steady clock (CLOCK_MONOTONIC): the clock of every age and every period.
double steadyNow();

/// s of the processor that the calling thread has had.
double threadTime();

/// Names the calling thread for whoever looks at the process: 15 letters at most.
void nameThread(const char* name);

/// Priorities of a node's threads: a cycle thread stands above the threads that roscpp starts.
constexpr int kCyclePriority = 80;
constexpr int kRosPriority = 60;

/// Locks the process's memory and gives the calling thread SCHED_FIFO, which the threads it starts inherit: called
/// before ros::init, the threads of roscpp keep up with the cycle as well. Returns what was not allowed, in words;
/// empty when all was.
std::string requestRealTime(int priority = kRosPriority);

/// Gives the calling thread SCHED_FIFO at `priority` when `requestRealTime` was allowed to; otherwise leaves it alone.
void raisePriority(int priority);

/// Lets the calling thread, one without SCHED_FIFO, come before the ordinary ones when `requestRealTime` was allowed
/// to.
void standAboveNormal();

/// As long as it lives, its thread and those that it starts run without SCHED_FIFO: for set-up and other work that
/// takes long, which must not keep the processor from the cycles of other nodes.
class NormalPriority {
 public:
  NormalPriority();
  ~NormalPriority();
  NormalPriority(const NormalPriority&) = delete;
  NormalPriority& operator=(const NormalPriority&) = delete;

 private:
  int policy_;
  int priority_;
};

/// Wakes its thread once a period by absolute times of the steady clock, so that lateness never adds up.
class PeriodicWakeUp {
 public:
  explicit PeriodicWakeUp(double period);

  /// Sleeps until the next period begins. Periods that have passed already are left out, never made up for in a burst.
  void wait();

  double period() const { return static_cast<double>(period_) * 1e-9; }   ///< s
  double scheduled() const { return static_cast<double>(next_) * 1e-9; }  ///< s, steady: when the present period began
  std::uint64_t skipped() const { return skipped_; }                      ///< 1, periods left out since the start

 private:
  std::int64_t period_;  // ns
  std::int64_t next_;    // ns, steady
  std::uint64_t skipped_ = 0;
};

}  // namespace sinew
