#pragma once

#include <cstdint>
#include <memory>

#include "applied_estimate.h"
#include "ros_conversions.h"
#include "sinew/inverse/inverse_controller.h"

namespace sinew {

/// The controller and where its commands stand: the cycle thread's, or the service thread's while parked.
struct ControlSession {
  explicit ControlSession(const std::shared_ptr<const RobotModel>& robot, double period);

  InverseController controller;
  CycleInput input;
  CycleOutput output;
  AppliedEstimate applied;
  VecX followed;             ///< m, where the disabled model is
  VecX last_command;         ///< m
  bool with_driver = false;  ///< this session needs one
  std::uint32_t session = 0;
  std::uint32_t sequence = 0;
  double enabled_since = 0;  ///< s, steady
};

/// Whether the driver can be told anything: READY, ACTIVE or HOLDING.
bool takesCommands(std::uint8_t driver_state);

/// Whether the driver has been heard of within `timeout` [s] before `now` [s, steady].
bool isFresh(const DriverReading& reading, double now, double timeout);

}  // namespace sinew
