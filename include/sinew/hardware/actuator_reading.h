#pragma once

#include <cstdint>

namespace sinew {

/// What an actuator is told and measures; the numbers are those of the message ActuatorCommand.
enum class Quantity : std::uint8_t {
  kDisplacement = 0,  ///< m, cable pulled in is positive
  kTension = 1,       ///< N
  kPressure = 2,      ///< Pa, gauge
  kVolume = 3         ///< m3, growth is positive
};

/// What is wrong with an actuator, whatever its device. A device's own error registers are brought to these bits.
enum ActuatorFault : std::uint32_t {
  // Said by the device; the low byte is the hardware error register of a Dynamixel.
  kFaultVoltage = 1u << 0,     ///< supply too high or too low
  kFaultSensor = 1u << 1,      ///< Hall or pressure sensor
  kFaultOverheated = 1u << 2,  ///< the device has shut down for its temperature
  kFaultEncoder = 1u << 3,
  kFaultElectrical = 1u << 4,  ///< short circuit, electronics, firmware
  kFaultOverload = 1u << 5,    ///< overload, overcurrent
  kFaultFollowing = 1u << 6,   ///< the device cannot follow its set point
  kFaultDevice = 1u << 7,      ///< any other error of the device's own
  // Seen by the driver.
  kFaultSilent = 1u << 8,        ///< no valid reading for missing_limit cycles
  kFaultWatchdog = 1u << 9,      ///< the device has stopped by itself because nobody spoke to it
  kFaultOff = 1u << 10,          ///< off though it was switched on: it restarted or shut down
  kFaultJumped = 1u << 11,       ///< its position jumped: the zero is lost
  kFaultUndervolted = 1u << 12,  ///< its supply dipped: the zero may be lost
  kFaultDifference =
      1u << 13,              ///< measured and applied differ for too long: cable snapped or stuck, leak, blocked hose
  kFaultHot = 1u << 14,      ///< above the driver's own limit of temperature
  kFaultCurrent = 1u << 15,  ///< above the driver's own limit of current
  kFaultPressure = 1u << 16  ///< above the driver's own limit of pressure
};

/// What is known of one actuator.
struct ActuatorReading {
  bool valid = false;       ///< this cycle brought a reading; otherwise the rest is the last one
  double measured = 0;      ///< m or Pa, the quantity that is commanded
  double effort = 0;        ///< N of a cable, from the motor current; Pa of a pressure channel
  double current = 0;       ///< A, positive while it reels in; 0 where the device does not tell
  double temperature = 0;   ///< degC; 0 where the device does not tell
  double voltage = 0;       ///< V of the supply; 0 where the device does not tell
  bool zero_valid = false;  ///< `measured` counts from the robot's zero. Always true for pressures
  std::uint32_t fault = 0;  ///< ActuatorFault, kept until the next set-up
  int missing = 0;          ///< cycles in a row without a valid reading
};

}  // namespace sinew
