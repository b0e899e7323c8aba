#include "sinew/hardware/serial_port.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "file_descriptor.h"

namespace sinew {
namespace {

std::string calcHint(int number) {
  if (number == ENOENT) return "; is the adapter plugged in and the path right?";
  if (number == EACCES) return "; add the user to the group that owns the port (dialout)";
  if (number == EBUSY) return "; another program has it open";
  return "";
}

bool requestLowLatency(int fd) {
  serial_struct settings{};
  if (ioctl(fd, TIOCGSERIAL, &settings) != 0) return false;
  settings.flags |= ASYNC_LOW_LATENCY;
  return ioctl(fd, TIOCSSERIAL, &settings) == 0;
}

}  // namespace

bool SerialPort::fail(const std::string& what, int number) {
  close();
  error_ = what + ": " + strerror(number) + calcHint(number);
  return false;
}

bool SerialPort::open(const std::string& path, int baud) {
  close();
  error_.clear();
  fd_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) return fail("cannot open " + path, errno);
  if (ioctl(fd_, TIOCEXCL) != 0) return fail("cannot lock " + path, errno);
  if (!makeRaw(fd_, baud)) return fail("cannot set " + path + " to " + std::to_string(baud) + " baud", errno);
  low_latency_ = requestLowLatency(fd_);
  tcflush(fd_, TCIOFLUSH);
  return true;
}

void SerialPort::close() {
  if (fd_ >= 0) {
    ioctl(fd_, TIOCNXCL);
    ::close(fd_);
  }
  fd_ = -1;
  low_latency_ = false;
}

StreamResult SerialPort::closeIfGone(StreamResult result) {
  if (result.status == StreamStatus::kClosed) close();
  return result;
}

StreamResult SerialPort::read(std::uint8_t* data, std::size_t capacity, Duration timeout) {
  return closeIfGone(readDescriptor(fd_, data, capacity, timeout));
}

StreamResult SerialPort::write(const std::uint8_t* data, std::size_t size, Duration timeout) {
  return closeIfGone(writeDescriptor(fd_, data, size, timeout));
}

bool isPseudoTerminal(const std::string& path) {
  char* real = realpath(path.c_str(), nullptr);
  const std::string resolved = real != nullptr ? real : path;
  free(real);
  return resolved.rfind("/dev/pts/", 0) == 0;
}

}  // namespace sinew
