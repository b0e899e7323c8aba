#include "control_settings.h"

#include "real_time.h"

namespace sinew {
namespace {

OverloadLadder::Settings readOverload(const Parameters& parameters) {
  OverloadLadder::Settings settings;
  settings.above = parameters.numberOr("overload_above", settings.above, 0.05, 1);
  settings.below = parameters.numberOr("overload_below", settings.below, 0.01, settings.above);
  settings.recovery = parameters.numberOr("overload_recovery", settings.recovery, 0.01, 3600);
  return settings;
}

}  // namespace

ControlSettings::ControlSettings(const Parameters& parameters)
    : rate(parameters.numberOr("rate", 100, 1, 2000)),
      body_state_rate(parameters.numberOr("body_state_rate", 30, 0.1, 1000)),
      driver_timeout(parameters.numberOr("driver_timeout", 0.5, 0.01, 60)),
      transform_tolerance(parameters.numberOr("transform_tolerance", 0.1, 0.0, 1e6)),
      obstacles(ObstacleInbox::Settings::read(parameters)),
      overload(readOverload(parameters)),
      require_driver(parameters.flagOr("require_driver", true)),
      auto_enable(parameters.flagOr("auto_enable", false)),
      priority(parameters.integerOr("priority", kCyclePriority, 1, 98)) {}

}  // namespace sinew
