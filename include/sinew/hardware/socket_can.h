#pragma once

#include <cstdint>
#include <string>

#include "sinew/hardware/can_port.h"

namespace sinew {

/// What the kernel told about a CAN bus, counted since the port was opened.
struct CanErrors {
  std::uint64_t unacknowledged = 0;  ///< frames that no other node acknowledged
  std::uint64_t warnings = 0;        ///< the controller's error counters are high: wiring, termination, bit rate
  std::uint64_t lost = 0;            ///< frames lost because nobody fetched them in time
};

/// A CAN interface of the kernel (SocketCAN): can0, vcan0, slcan0. A bus that is off, an interface that is down or an
/// adapter that is unplugged shows as kClosed.
class SocketCan : public CanPort {
 public:
  SocketCan() = default;
  ~SocketCan() override { close(); }
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  /// Opens `interface`. On failure returns false, and `error()` says why and what would help.
  bool open(const std::string& interface);
  void close();
  bool isOpen() const { return fd_ >= 0; }
  /// Why it could not be opened, or why it closed.
  const std::string& error() const { return error_; }
  const CanErrors& errors() const { return errors_; }

  StreamStatus send(const CanFrame& frame, Duration timeout) override;
  StreamStatus receive(CanFrame& frame, Duration timeout) override;
  std::uint64_t damaged() const override { return errors_.lost; }

 private:
  bool fail(const std::string& why);
  StreamStatus gone(const std::string& why);
  bool takeErrorFrame(std::uint32_t id, const std::uint8_t* data);

  int fd_ = -1;
  std::string interface_;
  std::string error_;
  CanErrors errors_;
};

}  // namespace sinew
