#include "sinew/common/worker_team.h"

#include <cerrno>

namespace sinew {
namespace {

void wait(sem_t& semaphore) {
  while (sem_wait(&semaphore) != 0 && errno == EINTR) {
  }
}

}  // namespace

WorkerTeam::WorkerTeam(int size) : members_(static_cast<std::size_t>(size - 1)), caller_(pthread_self()) {
  sem_init(&done_, 0, 0);
  for (int i = 0; i + 1 < size; ++i) {
    sem_init(&members_[i].wanted, 0, 0);
    members_[i].thread = std::thread([this, i] { serve(i + 1); });
  }
}

WorkerTeam::~WorkerTeam() {
  call_ = nullptr;
  start();
  for (Member& member : members_) {
    member.thread.join();
    sem_destroy(&member.wanted);
  }
  sem_destroy(&done_);
}

void WorkerTeam::serve(int member) {
  pthread_t known = pthread_self();
  while (true) {
    wait(members_[static_cast<std::size_t>(member - 1)].wanted);
    if (call_ == nullptr) return;
    followCaller(known);
    call_(context_, member);
    sem_post(&done_);
  }
}

void WorkerTeam::followCaller(pthread_t& known) const {
  if (pthread_equal(known, caller_) != 0) return;
  known = caller_;
  int policy = SCHED_OTHER;
  sched_param parameters{};
  if (pthread_getschedparam(caller_, &policy, &parameters) != 0) return;
  pthread_setschedparam(pthread_self(), policy, &parameters);  // where that is not allowed it works on as it is
}

void WorkerTeam::start() {
  caller_ = pthread_self();
  for (Member& member : members_) sem_post(&member.wanted);
}

void WorkerTeam::finish() {
  for (std::size_t i = 0; i < members_.size(); ++i) wait(done_);
}

}  // namespace sinew
