#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <string>
#include <vector>

#include "callback_thread.h"
#include "sinew/common/newest_wins.h"
#include "sinew/hardware/hardware_driver.h"

namespace sinew {

/// Services that are answered one after the other, on a thread of their own, and what they see of the driver.
class ServiceLane {
 public:
  using Verb = std::function<void(std_srvs::Trigger::Response& response)>;

  ServiceLane(const ros::NodeHandle& node, const DriverReport& report) : reports(report), node_(node), thread_(queue_) {
    node_.setCallbackQueue(&queue_);
  }

  void advertise(const std::string& name, const Verb& verb) {
    using Callback = boost::function<bool(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&)>;
    const Callback callback = [verb](std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
      verb(response);
      return true;
    };
    servers_.push_back(node_.advertiseService(name, callback));
  }
  void start() { thread_.start(); }
  void stop() { thread_.stop(); }

  NewestWins<DriverReport> reports;  ///< written by the bus thread, read by this lane's

 private:
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  CallbackThread thread_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace sinew
