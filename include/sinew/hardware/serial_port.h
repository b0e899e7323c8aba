#pragma once

#include <string>

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// A serial port (or the driver's end of a pseudo-terminal): raw, 8 data bits, no parity, 1 stop bit, any baud rate
/// that the adapter can make, exclusive to this process. An unplugged adapter shows as kClosed.
class SerialPort : public ByteStream {
 public:
  SerialPort() = default;
  ~SerialPort() override { close(); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Opens `path` at `baud`. On failure returns false, and `error()` says why and what would help. Asks the adapter for
  /// low latency, which not every one knows; see `lowLatency()`.
  bool open(const std::string& path, int baud);
  void close();
  bool isOpen() const { return fd_ >= 0; }
  /// Whether the kernel's driver took the low-latency flag. Pseudo-terminals have none.
  bool lowLatency() const { return low_latency_; }
  const std::string& error() const { return error_; }

  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) override;
  StreamResult write(const std::uint8_t* data, std::size_t size, Duration timeout) override;

 private:
  bool fail(const std::string& what, int number);
  StreamResult closeIfGone(StreamResult result);

  int fd_ = -1;
  bool low_latency_ = false;
  std::string error_;
};

/// Whether `path`, with symbolic links followed, is the end of a pseudo-terminal and so no real device.
bool isPseudoTerminal(const std::string& path);

}  // namespace sinew
