#pragma once

#include "obstacle_inbox.h"
#include "parameters.h"
#include "sinew/inverse/overload_ladder.h"

namespace sinew {

/// The parameters of the inverse model's cycle.
struct ControlSettings {
  /// Throws ConfigError when one is not right.
  explicit ControlSettings(const Parameters& parameters);

  double period() const { return 1 / rate; }  ///< s

  double rate;                 ///< Hz
  double body_state_rate;      ///< Hz
  double driver_timeout;       ///< s
  double transform_tolerance;  ///< s
  ObstacleInbox::Settings obstacles;
  OverloadLadder::Settings overload;
  bool require_driver;
  bool auto_enable;
  int priority;
};

}  // namespace sinew
