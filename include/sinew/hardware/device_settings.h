#pragma once

#include <string>

namespace sinew {

/// What every device on a bus has to know of its robot and its bus.
struct DeviceTiming {
  double period = 0;         ///< s of a cycle
  double watchdog = 0;       ///< s of silence after which the device is to stop by itself
  double reply_timeout = 0;  ///< s an answer may be late
  int missing_limit = 0;     ///< cycles in a row without a valid reading after which a device counts as lost
};

/// The name, place and bounds of one actuator, as far as its device has to know them.
struct ActuatorBounds {
  std::string name;     ///< for messages
  double min = 0;       ///< m or Pa
  double max = 0;       ///< m or Pa
  double rate_max = 0;  ///< m/s or Pa/s
};

}  // namespace sinew
