#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "sinew/hardware/actuator_reading.h"
#include "sinew/hardware/canopen_settings.h"
#include "sinew/hardware/device_settings.h"
#include "sinew/hardware/odrive_settings.h"
#include "sinew/hardware/pressure_board_settings.h"
#include "sinew/hardware/winch_description.h"

namespace sinew {

/// What an actuator does when commands fail for longer than the hold limit, when the driver faults, or at an emergency
/// stop.
enum class OnTimeout {
  kHold,   ///< stays: a servo at its set point, a pressure channel with its valves closed
  kRelax,  ///< a cable gives its tension away, then its torque goes off
  kVent    ///< a pressure channel goes down to the pressure around it
};

enum class BusType { kDynamixel, kCan, kPressureBoard };
enum class DeviceType { kDynamixel, kCanopen, kOdrive, kPressureBoard };

/// One line to devices.
struct BusDescription {
  std::string name;
  BusType type = BusType::kDynamixel;
  std::string port;          ///< path of a serial port (or of an SLCAN adapter), or name of a CAN interface
  int baud = 0;              ///< 1/s, of the serial port, also of an SLCAN adapter's
  int bitrate = 0;           ///< bit/s of a CAN bus
  bool simulated = false;    ///< nothing real hangs on the port, so it may be opened under simulated time
  double reply_timeout = 0;  ///< s an answer may be late
  int missing_limit = 0;     ///< cycles in a row without a valid reading after which a device counts as lost

  /// Whether the port is the name of a CAN interface of the kernel, and not a path.
  bool isCanInterface() const { return type == BusType::kCan && port.find('/') == std::string::npos; }
};

/// What the driver itself watches, beyond what devices report. Infinity watches nothing.
struct WatchDescription {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  double difference_max = kNever;   ///< m or Pa between measured and applied ...
  double effort_missing = kNever;   ///< N that a cable may carry less than the controller expects ...
  double time = 0;                  ///< ... for so long, s
  double temperature_max = kNever;  ///< degC
  double current_max = kNever;      ///< A
  double pressure_max = kNever;     ///< Pa measured
};

/// What the file gives for one kind of device, beyond what all have in common. A Dynamixel needs no more.
using DeviceSettings = std::variant<std::monostate, CanopenSettings, OdriveSettings, PressureBoardSettings>;

/// One actuator: a motor that reels a cable, or a channel that holds a pressure.
struct ActuatorDescription {
  std::string name;
  int bus = 0;  ///< index of its bus
  DeviceType device = DeviceType::kDynamixel;
  int id = 0;       ///< of its device on the bus
  int channel = 0;  ///< of its device
  Quantity quantity = Quantity::kDisplacement;
  double min = 0, max = 0;  ///< m or Pa
  double rate_max = 0;      ///< m/s or Pa/s
  OnTimeout on_timeout = OnTimeout::kHold;
  WatchDescription watch;
  WinchDescription cable;  ///< of a motor
  DeviceSettings settings;

  /// By how much a first command may differ from the measurement: 0.1 mm, or 1 % of the range of a pressure.
  double seedTolerance() const { return quantity == Quantity::kDisplacement ? 1e-4 : 0.01 * (max - min); }
  ActuatorBounds bounds() const { return {name, min, max, rate_max}; }
};

/// Something that a person hits to stop the robot, beside the topic and the service.
struct EmergencyStopDescription {
  std::string input;  ///< path of a Linux input device, e.g. /dev/input/by-id/...-event-kbd; empty for none
};

/// The devices of a robot and the driver's own limits.
struct HardwareDescription {
  double rate = 0;             ///< Hz of the cycle without commands, and the rate step's base
  double command_timeout = 0;  ///< s without a command until the driver holds
  double hold_limit = 0;       ///< s of holding until on_timeout
  double relax_time = 0;       ///< s in which a relaxing actuator gives its effort away
  double bus_watchdog = 0;     ///< s after which a device stops by itself when the bus is silent
  EmergencyStopDescription emergency_stop;
  std::vector<BusDescription> buses;
  std::vector<ActuatorDescription> actuators;

  /// Reads `path`. Throws ConfigError that gives the file, the key in full, the value found and what would be right.
  static HardwareDescription load(const std::string& path);
  /// The same from text; `source` names it in errors.
  static HardwareDescription parse(const std::string& text, const std::string& source);

  /// Lets every port of a serial line be `port`, followed by '_' and the name of the bus where there are several. CAN
  /// interfaces of the kernel that are virtual themselves (vcan...) stay.
  void movePorts(const std::string& port);

  std::vector<std::string> names() const;
  std::vector<Quantity> quantities() const;
  /// Indices of the actuators on a bus, in the order of the file: that is how they are numbered there.
  std::vector<int> actuatorsOn(int bus) const;
  DeviceTiming timing(int bus) const;
};

}  // namespace sinew
