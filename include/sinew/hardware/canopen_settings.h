#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "sinew/common/yaml_reader.h"

namespace sinew {

/// By which objects a drive bounds and tells its torque.
enum class CanopenEffort {
  kTorque,       ///< 6072 and 6077, per mille of the rated torque 6076
  kCurrent,      ///< 6073 and 6078, per mille of the rated current 6075
  kEpos4Current  ///< 3001:02 and 30D1:02, mA
};

/// The unit of a drive's speeds; accelerations are per second of it.
enum class CanopenSpeed {
  kRpm,     ///< of the motor
  kCounts,  ///< counts/s
};

/// A value for an entry of the drive's object dictionary.
struct CanopenObject {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::uint8_t size = 0;    ///< bytes: 1, 2 or 4
  std::uint32_t value = 0;  ///< negative ones as their two's complement
};

/// A drive's own search for its zero.
struct CanopenHoming {
  std::int8_t method = 0;   ///< object 6098; 0: none
  double search_speed = 0;  ///< rad/s of the spool, towards the switch (6099:01)
  double zero_speed = 0;    ///< rad/s of the spool, back from it (6099:02)
  double acceleration = 0;  ///< rad/s2 of the spool (609A)
  double timeout = 0;       ///< s
};

/// What the driver has to know of one CANopen drive beyond its cable.
struct CanopenSettings {
  std::uint8_t node = 0;          ///< 1 to 127
  std::uint8_t driver_node = 0;   ///< whose heartbeat the driver sends, 1 to 127
  std::uint32_t vendor = 0;       ///< object 1018:01; 0: any
  std::uint32_t product = 0;      ///< object 1018:02; 0: any
  double counts_per_turn = 0;     ///< of the motor's shaft, quadrature included
  double gear = 1;                ///< turns of the motor per turn of the spool
  bool absolute_encoder = false;  ///< its position outlives power loss
  CanopenEffort effort = CanopenEffort::kTorque;
  double rated_unit = 0;  ///< N m or A per unit of the rated torque or current
  CanopenSpeed speed = CanopenSpeed::kRpm;
  double heartbeat = 0;  ///< s between those of the drive (1017)
  /// m of cable that the position may be off until the drive raises a fault (6065); infinite: it never does.
  double following_window = std::numeric_limits<double>::infinity();
  /// s for which the drive may say that it runs at one of its limits until that counts as overload; infinite: for ever.
  double limit_time = std::numeric_limits<double>::infinity();
  bool hold_on_silence = true;  ///< after a quick stop the drive holds its position; otherwise it lets go
  std::vector<CanopenObject> objects;
  CanopenHoming homing;

  /// Reads the mapping of one actuator (see docs/hardware.md); throws ConfigError.
  static CanopenSettings read(const YamlReader& reader);
};

}  // namespace sinew
