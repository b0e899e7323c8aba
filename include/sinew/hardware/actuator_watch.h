#pragma once

#include <cstdint>
#include <vector>

#include "sinew/hardware/actuator_reading.h"
#include "sinew/hardware/hardware_description.h"

namespace sinew {

/// Compares what actuators measure with what they were told, and with the driver's own limits. What a device would
/// stop for by itself is its own affair; this finds what no device can know: a snapped cable, a leak, a stuck spool.
class ActuatorWatch {
 public:
  explicit ActuatorWatch(const std::vector<ActuatorDescription>& actuators);

  void reset();

  /// One cycle of `dt` [s]. `applied` [m or Pa]: the set points; `expected` [N]: what the controller expects cables to
  /// carry, not finite where it does not say. Readings that are not valid leave everything as it is. Returns whether
  /// all is well.
  bool update(const std::vector<ActuatorReading>& readings, const std::vector<double>& applied, const double* expected,
              double dt);

  /// ActuatorFault bits of actuator `i`, kept until `reset`.
  std::uint32_t fault(int i) const { return states_[static_cast<std::size_t>(i)].fault; }

 private:
  struct State {
    WatchDescription limits;
    double off_time = 0, slack_time = 0, over_time = 0;  // s for which a limit has been passed
    std::uint32_t fault = 0;
  };
  std::vector<State> states_;
};

}  // namespace sinew
