#pragma once

#include <vector>

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// Which actuators give their effort away, and how much of it they may still exert: 1 at the start, 0 after the time.
class ReleaseRamp {
 public:
  /// `time` [s] from everything to nothing.
  ReleaseRamp(std::size_t actuators, double time) : time_(time), which_(actuators, false) {}

  /// Begins with the next `share`; nothing happens when no actuator is chosen.
  void start(const std::vector<bool>& which);
  void stop() { active_ = false; }

  bool active() const { return active_; }
  const std::vector<bool>& which() const { return which_; }
  /// From 1 at the first call after `start` down to 0.
  double share(Time now);

 private:
  double time_;
  std::vector<bool> which_;
  bool active_ = false, started_ = false;
  Time begin_{};
};

}  // namespace sinew
