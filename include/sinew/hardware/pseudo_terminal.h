#pragma once

#include <string>

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// The device's end of a pseudo-terminal: a driver opens `path()` as if it were a serial port. The line is raw and has
/// no baud rate. The driver's end may be closed and opened again at will.
class PseudoTerminal : public ByteStream {
 public:
  /// Opens a pair. With a non-empty `link`, a symbolic link of that name to the driver's end replaces any earlier
  /// symbolic link there, and is removed at destruction. Throws ConfigError when the pair or the link cannot be made.
  explicit PseudoTerminal(const std::string& link = "");
  ~PseudoTerminal() override;
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  /// Path of the driver's end, /dev/pts/N.
  const std::string& path() const { return path_; }

  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) override;
  StreamResult write(const std::uint8_t* data, std::size_t size, Duration timeout) override;

 private:
  int master_ = -1;
  int slave_ = -1;  // kept open, so that the pair survives when the driver closes its end
  std::string path_;
  std::string link_;
};

}  // namespace sinew
