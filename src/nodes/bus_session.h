#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sinew/hardware/emergency_stop_input.h"
#include "sinew/hardware/hardware_driver.h"

namespace sinew {

/// From now on Ctrl-C and SIGTERM are only noted: whatever is switched on is let go first.
void catchStops();
bool isStopAsked();

/// The description of the actuators `which` (indices) and their buses alone.
HardwareDescription select(const HardwareDescription& hardware, const std::vector<int>& which);
/// Lets set-up find every cable where it is, so that none moves.
void homeWhereFound(HardwareDescription& hardware);

/// Removes what drivers have kept of the zeros of these actuators. A servo that has lost its zero shows it only until
/// it is set up again, so that a driver must not trust what it kept from before.
void forgetZeros(const std::vector<std::string>& actuators);

/// The driver's loop at a terminal: sets devices up, keeps them at work, and lets go at the end, whatever happens.
class BusSession {
 public:
  /// Throws ConfigError where bus and devices do not fit.
  explicit BusSession(const HardwareDescription& hardware);
  ~BusSession() { letGo(); }
  BusSession(const BusSession&) = delete;
  BusSession& operator=(const BusSession&) = delete;

  /// Connects, homes and switches on; zeros of before are forgotten. False when a device is not well or a stop was
  /// asked for; see `whyNot`.
  bool setUp();
  /// Why a robot that is not ready is not.
  std::string whyNot() const;
  /// One cycle, in its time.
  const DriverReport& cycle();
  /// One cycle at once.
  const DriverReport& cycleNow();
  /// Commands `set_points` [m or Pa], one per actuator.
  void command(const std::vector<double>& set_points);
  /// Every actuator gives its effort away and is switched off.
  void letGo();

  const DriverReport& report() const { return driver_.report(); }
  const HardwareDescription& hardware() const { return hardware_; }
  double period() const { return 1 / hardware_.rate; }

 private:
  void lookAtEmergencyStop();

  HardwareDescription hardware_;
  HardwareDriver driver_;
  EmergencyStopInput emergency_stop_;
  Time next_;
  std::uint32_t sequence_ = 0;
};

}  // namespace sinew
