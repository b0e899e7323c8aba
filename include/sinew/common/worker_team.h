#pragma once

#include <pthread.h>
#include <semaphore.h>

#include <thread>
#include <vector>

namespace sinew {

/// Threads that share one piece of work with the caller, over and over. They sleep in between, and never spin: spinning
/// at the priority of a control loop would starve the rest of the machine. They take over the scheduling policy of the
/// thread that makes them.
class WorkerTeam {
 public:
  /// `size` counts the caller.
  explicit WorkerTeam(int size);
  ~WorkerTeam();
  WorkerTeam(const WorkerTeam&) = delete;
  WorkerTeam& operator=(const WorkerTeam&) = delete;

  int size() const { return static_cast<int>(members_.size()) + 1; }

  /// Calls work(0) here and work(1) ... work(size - 1) on the others; returns when all have. No allocation.
  template <typename Work>
  void run(const Work& work) {
    call_ = [](const void* context, int member) { (*static_cast<const Work*>(context))(member); };
    context_ = &work;
    start();
    work(0);
    finish();
  }

 private:
  struct Member {
    sem_t wanted;
    std::thread thread;
  };

  void serve(int member);
  void followCaller(pthread_t& known) const;
  void start();
  void finish();

  std::vector<Member> members_;
  sem_t done_;
  void (*call_)(const void* context, int member) = nullptr;  // nullptr ends the threads
  const void* context_ = nullptr;
  pthread_t caller_;
};

}  // namespace sinew
