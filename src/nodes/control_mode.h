#pragma once

#include <atomic>

namespace sinew {

enum class Mode {
  kFollowing,   ///< disabled: the model follows what the driver measures
  kParked,      ///< disabled: the controller belongs to the service thread
  kControlling  ///< enabled
};

/// Who owns the controller: the cycle thread while it follows or controls, the service thread while it is parked.
/// Parking is granted at the start of a cycle that leaves the controller alone, and taken back by the first one that
/// does not. The cycle thread never waits.
class ControlMode {
 public:
  explicit ControlMode(double period) : period_(period) {}

  /// Cycle thread, at the start of a cycle: its mode.
  Mode grant();
  /// Cycle thread: from the next cycle on disabled, unless the service thread has asked for something else.
  void disable(const char* reason);

  /// Service thread: returns when the controller is its own.
  void park();
  /// Service thread: gives it back, with the reason why it is disabled if it is; returns when it is gone.
  void release(Mode mode, const char* reason);

  bool enabled() const { return wanted_.load(std::memory_order_acquire) == Mode::kControlling; }
  const char* disabledReason() const { return disabled_reason_.load(std::memory_order_acquire); }

 private:
  void waitUntilParked(bool parked) const;

  double period_;  // s
  std::atomic<Mode> wanted_{Mode::kFollowing};
  std::atomic<Mode> granted_{Mode::kFollowing};
  std::atomic<const char*> disabled_reason_{"not enabled yet"};
};

}  // namespace sinew
