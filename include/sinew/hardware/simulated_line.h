#pragma once

#include "sinew/hardware/simulated_servo_bus.h"

namespace sinew {

/// The master's end of a line to simulated servos, without an operating system in between and on a clock of its own:
/// waiting for bytes moves that clock, so that timeouts, delays and the time on the line are exact and repeatable. The
/// servos' mechanics stay where `SimulatedServoBus::step()` left them.
class SimulatedLine : public ByteStream {
 public:
  explicit SimulatedLine(SimulatedServoBus& bus) : bus_(bus) {}

  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) override;
  StreamResult write(const std::uint8_t* data, std::size_t size, Duration timeout) override;
  Time now() const override { return now_; }

  /// Lets time pass up to `t`; earlier times change nothing.
  void advanceTo(Time t) { now_ = t > now_ ? t : now_; }
  /// Pulls the plug, or puts it back in.
  void setPlugged(bool plugged) { plugged_ = plugged; }
  bool plugged() const { return plugged_; }

 private:
  SimulatedServoBus& bus_;
  Time now_{std::chrono::seconds(1)};
  bool plugged_ = true;
};

}  // namespace sinew
