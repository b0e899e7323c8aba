#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "sinew/hardware/can_port.h"
#include "sinew/hardware/slcan_codec.h"

namespace sinew {

/// A CAN bus behind a serial adapter that speaks LAWICEL's ASCII protocol (CANUSB, CANable with slcan firmware,
/// USBtin and others). An unplugged adapter shows as kClosed.
class SlcanPort : public CanPort {
 public:
  SlcanPort() = default;
  ~SlcanPort() override { close(); }
  SlcanPort(const SlcanPort&) = delete;
  SlcanPort& operator=(const SlcanPort&) = delete;

  /// Closes the adapter's channel, sets `bitrate` [bit/s] (10k, 20k, 50k, 100k, 125k, 250k, 500k, 800k or 1M) and opens
  /// it, each answered within `timeout`. On failure returns false, and `error()` says why and what would help.
  bool open(std::shared_ptr<ByteStream> line, int bitrate, Duration timeout = std::chrono::milliseconds(300));
  /// Closes the adapter's channel as far as it still listens.
  void close();
  bool isOpen() const { return line_ != nullptr; }
  const std::string& error() const { return error_; }

  StreamStatus send(const CanFrame& frame, Duration timeout) override;
  StreamStatus receive(CanFrame& frame, Duration timeout) override;
  Time now() const override { return line_ != nullptr ? line_->now() : Clock::now(); }

  /// Lines of the adapter that meant nothing, and commands that it has refused.
  std::uint64_t damaged() const override { return damaged_; }

 private:
  enum class Answer { kOk, kError, kNone, kClosed };
  bool fail(const std::string& why);
  Answer ask(const char* command, Duration timeout);
  StreamStatus nextEvent(SlcanEvent& event, Time deadline);
  StreamStatus gone();

  std::shared_ptr<ByteStream> line_;
  SlcanDecoder decoder_;
  std::array<std::uint8_t, 512> buffer_{};
  std::size_t begin_ = 0, end_ = 0;  // of what has been read and not decoded
  std::uint64_t damaged_ = 0;
  std::string error_;
};

}  // namespace sinew
