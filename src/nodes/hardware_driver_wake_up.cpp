#include "hardware_driver_wake_up.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace sinew {

WakeUp::WakeUp() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (event_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

WakeUp::~WakeUp() {
  close(event_);
}

void WakeUp::signal() {
  // Fails only when the counter is full, and then the reader wakes anyway.
  (void)!eventfd_write(event_, 1);
}

bool WakeUp::waitUntil(Time deadline) {
  const Duration left = std::max(Duration{0}, Duration(deadline - Clock::now()));
  const timespec wait{static_cast<time_t>(left.count() / 1000000000), static_cast<long>(left.count() % 1000000000)};
  pollfd event{event_, POLLIN, 0};
  ppoll(&event, 1, &wait, nullptr);
  eventfd_t count = 0;
  return eventfd_read(event_, &count) == 0;
}

}  // namespace sinew
