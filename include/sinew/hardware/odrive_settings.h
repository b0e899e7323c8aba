#pragma once

#include <cstdint>

#include "sinew/hardware/odrive_messages.h"

namespace sinew {

class YamlReader;

/// How a cable's ODrive axis is set up. The motor must be calibrated and must not start its closed loop by itself.
///
/// The axis' own watchdog stops it when its master falls silent. With `watchdog` the driver arms it over CAN (firmware
/// 0.6 and up); the numbers of the endpoints are those of `axis0.config.enable_watchdog` and
/// `axis0.config.watchdog_timeout` in the flat_endpoints.json of the very firmware. Without it, it has to be set with
/// odrivetool once, and set-up stays silent for as long as it takes the idle axis to report that its watchdog has
/// acted:
///   odrv0.axis0.config.watchdog_timeout = 0.1
///   odrv0.axis0.config.enable_watchdog = True
///   odrv0.save_configuration()
struct OdriveSettings {
  int node = 0;                                   ///< 0 to 62, axis0.config.can.node_id
  OdriveFirmware firmware = OdriveFirmware::k06;  ///< firmware: "0.5" or "0.6"
  double gear_ratio = 1;                          ///< turns of the motor for one of the spool
  OdriveInput input = OdriveInput::kPassThrough;  ///< input: pass_through or trapezoidal
  double acceleration = 0;                        ///< m/s2 of the cable, of the trapezoidal input
  bool cyclic = false;        ///< feedback: cyclic, when the axis sends estimates (0x09, 0x14, 0x17) by itself at least
                              ///< once a cycle; request, when it is to be asked
  double heartbeat = 0.1;     ///< s between heartbeats, axis0.config.can.heartbeat_msg_rate_ms
  double voltage_min = 10.5;  ///< V of supply below which the zero counts as lost
  struct Endpoints {
    bool given = false;
    std::uint16_t enable = 0;   ///< watchdog.enable_endpoint
    std::uint16_t timeout = 0;  ///< watchdog.timeout_endpoint
  } watchdog;

  /// Throws ConfigError.
  static OdriveSettings read(const YamlReader& yaml);
};

}  // namespace sinew
