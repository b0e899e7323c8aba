#include "file_descriptor.h"

// The kernel's own termios: unlike <termios.h>, which must not be included beside it, it takes any baud rate.
#include <asm/termbits.h>
#include <errno.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

namespace sinew {
namespace {

enum class Wait { kReady, kTimeout, kClosed };

Wait waitFor(int fd, short event, Duration timeout) {
  const Time deadline = Clock::now() + std::max(timeout, Duration{0});
  for (;;) {
    const Duration left = std::max(Duration{0}, Duration(deadline - Clock::now()));
    const timespec wait{static_cast<time_t>(left.count() / 1000000000), static_cast<long>(left.count() % 1000000000)};
    pollfd p{fd, event, 0};
    const int count = ppoll(&p, 1, &wait, nullptr);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return Wait::kClosed;
    if (count == 0) return Wait::kTimeout;
    if ((p.revents & event) != 0) return Wait::kReady;
    return Wait::kClosed;
  }
}

bool isTemporary(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

}  // namespace

StreamResult readDescriptor(int fd, std::uint8_t* data, std::size_t capacity, Duration timeout) {
  if (fd < 0) return {StreamStatus::kClosed, 0};
  if (capacity == 0) return {StreamStatus::kTimeout, 0};
  const Wait wait = waitFor(fd, POLLIN, timeout);
  if (wait == Wait::kTimeout) return {StreamStatus::kTimeout, 0};
  if (wait == Wait::kClosed) return {StreamStatus::kClosed, 0};
  const ssize_t count = ::read(fd, data, capacity);
  if (count > 0) return {StreamStatus::kOk, static_cast<std::size_t>(count)};
  if (count < 0 && isTemporary(errno)) return {StreamStatus::kTimeout, 0};
  return {StreamStatus::kClosed, 0};  // readable without bytes: hung up
}

StreamResult writeDescriptor(int fd, const std::uint8_t* data, std::size_t size, Duration timeout) {
  if (fd < 0) return {StreamStatus::kClosed, 0};
  const Time deadline = Clock::now() + timeout;
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::write(fd, data + done, size - done);
    if (count > 0) {
      done += static_cast<std::size_t>(count);
      continue;
    }
    if (count < 0 && !isTemporary(errno)) return {StreamStatus::kClosed, done};
    const Wait wait = waitFor(fd, POLLOUT, deadline - Clock::now());
    if (wait == Wait::kTimeout) return {StreamStatus::kTimeout, done};
    if (wait == Wait::kClosed) return {StreamStatus::kClosed, done};
  }
  return {StreamStatus::kOk, done};
}

bool makeRaw(int fd, int baud) {
  termios2 t{};
  if (ioctl(fd, TCGETS2, &t) != 0) return false;
  t.c_iflag = IGNBRK;
  t.c_oflag = 0;
  t.c_lflag = 0;
  t.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | (BOTHER << IBSHIFT);
  t.c_ispeed = t.c_ospeed = static_cast<speed_t>(baud);
  t.c_cc[VMIN] = 0;
  t.c_cc[VTIME] = 0;
  return ioctl(fd, TCSETS2, &t) == 0;
}

}  // namespace sinew
