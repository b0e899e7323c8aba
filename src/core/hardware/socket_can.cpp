#include "sinew/hardware/socket_can.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>

namespace sinew {
namespace {

constexpr can_err_mask_t kErrorsOfInterest = CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_ACK | CAN_ERR_TX_TIMEOUT;
constexpr int kReceiveBuffer = 1 << 20;                  // bytes asked for; the kernel grants what it allows
constexpr auto kRetry = std::chrono::microseconds(100);  // until the queue of an interface may have room again

ifreq makeRequest(const std::string& interface) {
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  return request;
}

std::string calcSocketHint(int number) {
  if (number == EAFNOSUPPORT || number == EPROTONOSUPPORT)
    return "; the kernel knows no CAN: modprobe can_raw (cloud kernels come without)";
  return "";
}

std::string calcUpHint(const std::string& interface) {
  if (interface.rfind("vcan", 0) == 0) return "ip link set " + interface + " up";
  return "ip link set " + interface + " up type can bitrate 1000000";
}

can_frame toKernel(const CanFrame& frame) {
  can_frame out{};
  out.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0u) | (frame.remote ? CAN_RTR_FLAG : 0u);
  out.can_dlc = frame.size;
  std::copy_n(frame.data.begin(), frame.size, out.data);
  return out;
}

CanFrame fromKernel(const can_frame& frame) {
  CanFrame out;
  out.extended = (frame.can_id & CAN_EFF_FLAG) != 0;
  out.remote = (frame.can_id & CAN_RTR_FLAG) != 0;
  out.id = frame.can_id & (out.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  out.size = std::min<std::uint8_t>(frame.can_dlc, 8);
  if (!out.remote) std::copy_n(frame.data, out.size, out.data.begin());
  return out;
}

bool isTemporary(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

// Waits for `event` or trouble; false when the time is over.
bool waitFor(int fd, short event, Time deadline) {
  const Duration left = std::max(Duration{0}, Duration(deadline - Clock::now()));
  const timespec wait{static_cast<time_t>(left.count() / 1000000000), static_cast<long>(left.count() % 1000000000)};
  pollfd p{fd, event, 0};
  return ppoll(&p, 1, &wait, nullptr) != 0;
}

}  // namespace

bool SocketCan::fail(const std::string& why) {
  close();
  error_ = why;
  return false;
}

bool SocketCan::open(const std::string& interface) {
  close();
  error_.clear();
  errors_ = {};
  interface_ = interface;
  if (interface.empty() || interface.size() >= IFNAMSIZ)
    return fail("'" + interface + "': the name of a CAN interface is wanted, e.g. can0");
  fd_ = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (fd_ < 0) return fail(std::string("cannot make a CAN socket: ") + strerror(errno) + calcSocketHint(errno));
  ifreq request = makeRequest(interface);
  if (ioctl(fd_, SIOCGIFINDEX, &request) != 0)
    return fail("no interface " + interface + "; is the adapter plugged in? `ip link` lists what there is");
  const int index = request.ifr_ifindex;
  if (ioctl(fd_, SIOCGIFHWADDR, &request) != 0 || request.ifr_hwaddr.sa_family != ARPHRD_CAN)
    return fail(interface + " is no CAN interface");
  if (ioctl(fd_, SIOCGIFFLAGS, &request) != 0 || (request.ifr_flags & IFF_UP) == 0)
    return fail(interface + " is down; as root: " + calcUpHint(interface));
  setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &kErrorsOfInterest, sizeof kErrorsOfInterest);
  setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return fail("cannot use " + interface + ": " + strerror(errno));
  return true;
}

void SocketCan::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

StreamStatus SocketCan::gone(const std::string& why) {
  fail(interface_ + " " + why);
  return StreamStatus::kClosed;
}

StreamStatus SocketCan::send(const CanFrame& frame, Duration timeout) {
  if (fd_ < 0) return StreamStatus::kClosed;
  const Time deadline = Clock::now() + timeout;
  const can_frame out = toKernel(frame);
  for (;;) {
    if (::write(fd_, &out, sizeof out) == static_cast<ssize_t>(sizeof out)) return StreamStatus::kOk;
    const int number = errno;
    if (number != ENOBUFS && !isTemporary(number)) return gone(std::string("does not send: ") + strerror(number));
    if (Clock::now() >= deadline) return StreamStatus::kTimeout;
    if (number == ENOBUFS) {  // the interface's queue is full, which poll does not see
      const timespec wait{0, std::chrono::nanoseconds(kRetry).count()};
      nanosleep(&wait, nullptr);
    } else {
      waitFor(fd_, POLLOUT, deadline);
    }
  }
}

StreamStatus SocketCan::receive(CanFrame& frame, Duration timeout) {
  if (fd_ < 0) return StreamStatus::kClosed;
  const Time deadline = Clock::now() + timeout;
  for (;;) {
    can_frame in{};
    const ssize_t count = ::read(fd_, &in, sizeof in);
    if (count == static_cast<ssize_t>(sizeof in)) {
      if ((in.can_id & CAN_ERR_FLAG) == 0) {
        frame = fromKernel(in);
        return StreamStatus::kOk;
      }
      if (!takeErrorFrame(in.can_id, in.data)) return gone("is off the bus: check wiring, termination and bit rate");
      continue;
    }
    if (count < 0 && !isTemporary(errno)) return gone(std::string("is gone: ") + strerror(errno));
    if (Clock::now() >= deadline) return StreamStatus::kTimeout;
    waitFor(fd_, POLLIN, deadline);
  }
}

// False when the controller has left the bus.
bool SocketCan::takeErrorFrame(std::uint32_t id, const std::uint8_t* data) {
  if ((id & (CAN_ERR_ACK | CAN_ERR_TX_TIMEOUT)) != 0) ++errors_.unacknowledged;
  if ((id & CAN_ERR_CRTL) != 0) {
    const bool overflow = (data[1] & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0;
    ++(overflow ? errors_.lost : errors_.warnings);
  }
  return (id & CAN_ERR_BUSOFF) == 0;
}

}  // namespace sinew
