#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sinew {

/// What a servo does when commands fail for longer than the hold limit, or when the driver faults.
enum class OnTimeout { kHold, kRelax };

enum class HomingMethod {
  kPresent,  ///< the position found is displacement 0
  kTension   ///< reel in slowly until the cable carries a tension: displacement 0
};

struct HomingDescription {
  HomingMethod method = HomingMethod::kPresent;
  double tension = 0;  ///< N at which the cable counts as taut
  double speed = 0;    ///< m/s of reeling in
  double travel = 0;   ///< m after which homing gives up
};

/// One servo that reels a cable.
struct ActuatorDescription {
  std::string name;
  std::uint8_t id = 0;
  double spool_radius = 0;      ///< m
  int sign = 1;                 ///< +1 when positive rotation of the servo reels in
  double displacement_min = 0;  ///< m
  double displacement_max = 0;  ///< m
  double rate_max = 0;          ///< m/s
  double tension_max = 0;       ///< N
  double torque_constant = 0;   ///< N m/A
  OnTimeout on_timeout = OnTimeout::kHold;
  HomingDescription homing;
};

/// The devices of a robot and the driver's own limits.
struct HardwareDescription {
  std::string port;            ///< path of the serial port
  int baud = 0;                ///< 1/s
  bool simulated = false;      ///< nothing real hangs on the port, so it may be opened under simulated time
  double reply_timeout = 0;    ///< s an answer may be late
  int missing_limit = 0;       ///< cycles in a row without a valid reading after which a device counts as lost
  double rate = 0;             ///< Hz of the cycle without commands, and the rate step's base
  double command_timeout = 0;  ///< s without a command until the driver holds
  double hold_limit = 0;       ///< s of holding until on_timeout
  double relax_time = 0;       ///< s in which a relaxing actuator gives its tension away
  double bus_watchdog = 0;     ///< s after which a device stops by itself when the bus is silent
  std::vector<ActuatorDescription> actuators;

  /// Reads `path`. Throws ConfigError that gives the file, the key in full, the value found and what would be right.
  static HardwareDescription load(const std::string& path);
  /// The same from text; `source` names it in errors.
  static HardwareDescription parse(const std::string& text, const std::string& source);

  std::vector<std::string> names() const;
  std::vector<std::uint8_t> ids() const;
};

}  // namespace sinew
