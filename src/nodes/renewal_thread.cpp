#include "renewal_thread.h"

#include "real_time.h"

namespace sinew {

RenewalThread::RenewalThread(InverseController& controller) : controller_(controller) {
  sem_init(&wanted_, 0, 0);
  const NormalPriority of_the_thread;
  thread_ = std::thread(&RenewalThread::run, this);
}

RenewalThread::~RenewalThread() {
  stop_ = true;
  sem_post(&wanted_);
  thread_.join();
  sem_destroy(&wanted_);
}

void RenewalThread::start() {
  busy_.store(true, std::memory_order_release);
  sem_post(&wanted_);
}

void RenewalThread::run() {
  nameThread("renewal");
  standAboveNormal();
  while (!stop_) {
    if (sem_wait(&wanted_) != 0 || stop_) continue;
    const double begin = threadTime();
    times_ = StageTimes();
    controller_.renew(times_);
    cost_ = threadTime() - begin;
    busy_.store(false, std::memory_order_release);
  }
}

}  // namespace sinew
