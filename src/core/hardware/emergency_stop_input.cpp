#include "sinew/hardware/emergency_stop_input.h"

#include <fcntl.h>
#include <linux/input.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <thread>

namespace sinew {

EmergencyStopInput::~EmergencyStopInput() {
  close();
}

void EmergencyStopInput::open() {
  fd_ = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ >= 0) countKeysDown();
}

void EmergencyStopInput::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

// A button that was hit before the driver started counts as well.
void EmergencyStopInput::countKeysDown() {
  unsigned char keys[KEY_MAX / 8 + 1] = {};
  keys_down_ = 0;
  if (ioctl(fd_, EVIOCGKEY(sizeof keys), keys) < 0) return;  // no real input device, a pipe say: nothing is down yet
  for (const unsigned char eight : keys) keys_down_ += __builtin_popcount(eight);
}

void EmergencyStopInput::update(Duration timeout) {
  if (fd_ < 0) open();
  if (fd_ < 0) {
    std::this_thread::sleep_for(timeout);
    return;
  }
  pollfd wait{fd_, POLLIN, 0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count();
  if (poll(&wait, 1, static_cast<int>(ms)) <= 0) return;
  if ((wait.revents & POLLIN) != 0) return takeEvents();
  close();
}

void EmergencyStopInput::takeEvents() {
  input_event event{};
  for (;;) {
    const ssize_t size = ::read(fd_, &event, sizeof event);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size != static_cast<ssize_t>(sizeof event)) return close();
    if (event.type == EV_SYN && event.code == SYN_DROPPED) countKeysDown();
    if (event.type != EV_KEY) continue;
    if (event.value == 1) ++keys_down_;
    if (event.value == 0) keys_down_ = std::max(0, keys_down_ - 1);
  }
}

}  // namespace sinew
