#pragma once

#include <ros/callback_queue.h>

#include <atomic>
#include <thread>

namespace sinew {

/// Takes the place of ros::spin() in nodes that run under SCHED_FIFO. From the start of a shutdown to its end
/// ros::spin() asks its closed queue again and again without sleeping, and so keeps the processor from the threads that
/// shut down.
void spinUntilShutdown();

/// One thread that serves one callback queue; takes the place of ros::AsyncSpinner for the same reason.
class CallbackThread {
 public:
  explicit CallbackThread(ros::CallbackQueue& queue) : queue_(queue) {}
  ~CallbackThread() { stop(); }
  CallbackThread(const CallbackThread&) = delete;
  CallbackThread& operator=(const CallbackThread&) = delete;

  void start();
  /// Returns when the callback under way has ended.
  void stop();

 private:
  ros::CallbackQueue& queue_;
  std::atomic<bool> running_{false};
  std::thread thread_;
};

}  // namespace sinew
