#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <std_msgs/Bool.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>

namespace sinew {

/// Everything by which a person presses the emergency stop and lets go of it again: the topic `emergency_stop`, and an
/// input device where one is described. Each holds by itself; the robot may move again when none is pressed.
class EmergencyStops {
 public:
  /// `input`: path of the input device, empty for none. `changed` is called after every change, from other threads.
  EmergencyStops(ros::NodeHandle node, const std::string& input, std::function<void()> changed);
  ~EmergencyStops();

  bool pressed() const { return by_topic_ || by_input_; }

 private:
  void onTopic(const std_msgs::Bool::ConstPtr& message);
  void watchInput(const std::string& path);

  std::function<void()> changed_;
  std::atomic<bool> by_topic_{false}, by_input_{false}, running_{true};
  ros::Subscriber topic_;
  std::thread watch_;
};

}  // namespace sinew
