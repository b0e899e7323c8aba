#pragma once

#include <semaphore.h>

#include <atomic>
#include <thread>

#include "sinew/inverse/inverse_controller.h"

namespace sinew {

/// Renews the controller's linearisation beside the cycles, where these cannot wait for it. Its thread comes before the
/// ordinary ones, but runs without SCHED_FIFO: it may take all that the cycles leave of the processor, and must not
/// keep them from it.
class RenewalThread {
 public:
  explicit RenewalThread(InverseController& controller);
  ~RenewalThread();
  RenewalThread(const RenewalThread&) = delete;
  RenewalThread& operator=(const RenewalThread&) = delete;

  /// Whether the last one has ended. Cycle thread, as all that follows.
  bool idle() const { return !busy_.load(std::memory_order_acquire); }
  /// After `InverseController::beginRenewal`, while idle.
  void start();
  /// s of the processor that the last one took; negative before the first.
  double cost() const { return cost_; }
  const StageTimes& times() const { return times_; }  ///< of the last one, while idle

 private:
  void run();

  InverseController& controller_;
  StageTimes times_;
  double cost_ = -1;  // s
  std::atomic<bool> busy_{false}, stop_{false};
  sem_t wanted_;
  std::thread thread_;
};

}  // namespace sinew
