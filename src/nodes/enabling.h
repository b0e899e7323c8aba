#pragma once

#include <memory>
#include <string>

#include "actuator_inbox.h"
#include "control_mode.h"
#include "control_session.h"
#include "control_settings.h"
#include "target_inbox.h"

namespace sinew {

/// Enables, disables and resets the controller from the service thread: it parks the cycle, moves the model, and gives
/// it back.
class Enabling {
 public:
  Enabling(const ControlSettings& settings, std::shared_ptr<const RobotModel> robot, const ActuatorInbox& actuators,
           TargetInbox& targets, ControlMode& mode, ControlSession& session);

  /// Returns why not; empty when it is enabled.
  std::string enable();
  void disable();
  /// Disabled, the model is at rest and the targets are forgotten.
  void reset();

 private:
  std::string findReasonNotTo(const DriverReading& reading) const;
  std::string resynchronise(const VecX& measured);
  std::string compareFirstCommand(const VecX& measured) const;
  void beginSession(const VecX& start);

  const ControlSettings& settings_;
  std::shared_ptr<const RobotModel> robot_;
  const ActuatorInbox& actuators_;
  TargetInbox& targets_;
  ControlMode& mode_;
  ControlSession& session_;
};

}  // namespace sinew
