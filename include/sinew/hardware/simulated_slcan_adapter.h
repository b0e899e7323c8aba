#pragma once

#include <cstdint>
#include <string>

#include "sinew/hardware/can_port.h"

namespace sinew {

/// An SLCAN adapter seen from its CAN side: what a driver commands over the serial line comes out as frames, and
/// frames put in go to the driver as text. It obeys C, O, S0 to S8, V, N, F, t, T, r and R, and answers like LAWICEL's
/// adapters; a channel that is not open neither sends nor receives.
class SimulatedSlcanAdapter : public CanPort {
 public:
  /// `line` must outlive the adapter.
  explicit SimulatedSlcanAdapter(ByteStream& line) : line_(line) {}

  /// To the driver; dropped while the channel is closed.
  StreamStatus send(const CanFrame& frame, Duration timeout) override;
  /// From the driver.
  StreamStatus receive(CanFrame& frame, Duration timeout) override;
  Time now() const override { return line_.now(); }

  bool isOpen() const { return open_; }
  /// The digit of the last bit rate set, -1 before.
  int bitrateDigit() const { return bitrate_digit_; }

 private:
  bool obey(CanFrame& frame);
  bool parseFrame(CanFrame& frame) const;
  void answer(const std::string& text);

  ByteStream& line_;
  std::string command_, pending_;
  bool open_ = false;
  int bitrate_digit_ = -1;
};

}  // namespace sinew
