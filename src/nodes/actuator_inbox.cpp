#include "actuator_inbox.h"

#include <ros/console.h>

#include "real_time.h"

namespace sinew {

ActuatorInbox::ActuatorInbox(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot)
    : robot_(std::move(robot)),
      reading_(makeReading(*robot_)),
      newest_(reading_),
      topic_(node.resolveName("actuator_state")) {
  subscriber_ = node.subscribe("actuator_state", 1, &ActuatorInbox::onState, this, ros::TransportHints().tcpNoDelay());
}

DriverReading ActuatorInbox::latest() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return reading_;
}

std::string ActuatorInbox::driverReason() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return reason_;
}

void ActuatorInbox::onState(const ActuatorState& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (const std::optional<Refusal> refusal = updateReading(message, *robot_, reading_)) {
    refusals_.add(*refusal);
    ROS_WARN_STREAM_THROTTLE(5.0, "refused a message on " << topic_ << ": " << refusal->words);
    return;
  }
  reading_.receipt = steadyNow();
  reason_ = message.reason;
  newest_.write(reading_);
}

}  // namespace sinew
