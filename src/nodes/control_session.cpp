#include "control_session.h"

namespace sinew {

ControlSession::ControlSession(const std::shared_ptr<const RobotModel>& robot, double period)
    : controller(robot),
      input(controller.makeInput()),
      output(controller.makeOutput()),
      applied(robot->actuatorCount()),
      followed(VecX::Zero(robot->actuatorCount())),
      last_command(followed) {
  controller.makeSpare();
  input.period = period;
  input.applied = followed;
  for (const Obstacle& obstacle : robot->obstacles()) input.obstacles.push_back({obstacle.pose, true});
}

bool takesCommands(std::uint8_t driver_state) {
  return driver_state == ActuatorState::READY || driver_state == ActuatorState::ACTIVE ||
         driver_state == ActuatorState::HOLDING;
}

bool isFresh(const DriverReading& reading, double now, double timeout) {
  return reading.receipt >= 0 && now - reading.receipt <= timeout;
}

}  // namespace sinew
