#pragma once

#include "sinew/hardware/can_port.h"
#include "sinew/hardware/simulated_can_bus.h"

namespace sinew {

/// The master's end of a simulated CAN bus, without an operating system in between and on a clock of its own: waiting
/// for frames moves that clock, so that timeouts, delays and the time on the bus are exact and repeatable. The devices'
/// mechanics stay where `SimulatedCanBus::step()` left them.
class SimulatedCanPort : public CanPort {
 public:
  explicit SimulatedCanPort(SimulatedCanBus& bus) : bus_(bus) { bus_.update(now_); }

  StreamStatus send(const CanFrame& frame, Duration timeout) override;
  StreamStatus receive(CanFrame& frame, Duration timeout) override;
  Time now() const override { return now_; }

  /// Lets time pass up to `t`; earlier times change nothing.
  void advanceTo(Time t);
  /// Pulls the plug, or puts it back in.
  void setPlugged(bool plugged) { plugged_ = plugged; }
  bool plugged() const { return plugged_; }

 private:
  SimulatedCanBus& bus_;
  Time now_{std::chrono::seconds(1)};
  bool plugged_ = true;
};

}  // namespace sinew
