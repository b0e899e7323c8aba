#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <mutex>
#include <string>

#include "refusal_log.h"
#include "ros_conversions.h"
#include "sinew/common/newest_wins.h"

namespace sinew {

/// Receives `actuator_state` and hands the newest reading to the cycle, and to whoever else asks.
class ActuatorInbox {
 public:
  ActuatorInbox(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot);

  /// The cycle's end of the exchange.
  NewestWins<DriverReading>& newest() { return newest_; }

  /// A copy for threads that may wait.
  DriverReading latest() const;
  /// Why the driver is in its state, in its own words.
  std::string driverReason() const;

  const std::string& topic() const { return topic_; }
  const RefusalLog& refusals() const { return refusals_; }

 private:
  void onState(const ActuatorState& message);

  std::shared_ptr<const RobotModel> robot_;
  mutable std::mutex mutex_;
  DriverReading reading_;  // under mutex_
  std::string reason_;     // under mutex_
  NewestWins<DriverReading> newest_;
  RefusalLog refusals_;
  std::string topic_;
  ros::Subscriber subscriber_;
};

}  // namespace sinew
