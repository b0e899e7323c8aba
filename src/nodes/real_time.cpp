#include "real_time.h"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace sinew {

namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1000000000;
constexpr int kNiceAboveNormal = -15;

std::atomic<bool> fifo_allowed{false};

std::int64_t steadyNanoseconds() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNanosecondsPerSecond + now.tv_nsec;
}

// With a memory limit, MCL_FUTURE would make a later allocation fail instead of page: then nothing is locked.
std::string lockMemory() {
  rlimit limit;
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && geteuid() != 0) {
    return "memory is not locked (memlock is limited)";
  }
  // Pages stay once they have been touched. To touch them all at once would take the processor for a tenth of a second.
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    return std::string("memory is not locked (") + std::strerror(errno) + ")";
  }
  // The heap keeps what it has been given, so that a page faulted in once stays.
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  return "";
}

std::string setFifo(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  return error == 0 ? "" : std::string("SCHED_FIFO is not allowed (") + std::strerror(error) + ")";
}

}  // namespace

double steadyNow() {
  return static_cast<double>(steadyNanoseconds()) * 1e-9;
}

std::string requestRealTime(int priority) {
  const std::string scheduling = setFifo(priority);
  if (!scheduling.empty()) return scheduling;  // without it, locked memory only takes it from others
  fifo_allowed = true;
  return lockMemory();
}

double threadTime() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

void nameThread(const char* name) {
  pthread_setname_np(pthread_self(), name);
}

void raisePriority(int priority) {
  if (fifo_allowed) setFifo(priority);
}

void standAboveNormal() {
  if (fifo_allowed) setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNiceAboveNormal);
}

NormalPriority::NormalPriority() {
  sched_param parameters{};
  pthread_getschedparam(pthread_self(), &policy_, &parameters);
  priority_ = parameters.sched_priority;
  parameters.sched_priority = 0;
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &parameters);
}

NormalPriority::~NormalPriority() {
  sched_param parameters{};
  parameters.sched_priority = priority_;
  pthread_setschedparam(pthread_self(), policy_, &parameters);
}

PeriodicWakeUp::PeriodicWakeUp(double period)
    : period_(std::llround(period * static_cast<double>(kNanosecondsPerSecond))), next_(steadyNanoseconds()) {}

void PeriodicWakeUp::wait() {
  next_ += period_;
  const std::int64_t late = steadyNanoseconds() - next_;
  if (late >= period_) {
    const std::int64_t missed = late / period_;
    next_ += missed * period_;
    skipped_ += static_cast<std::uint64_t>(missed);
  }
  timespec until;
  until.tv_sec = next_ / kNanosecondsPerSecond;
  until.tv_nsec = next_ % kNanosecondsPerSecond;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace sinew
