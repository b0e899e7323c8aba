#include "emergency_stops.h"

#include <ros/console.h>

#include <utility>

#include "sinew/hardware/emergency_stop_input.h"

namespace sinew {
namespace {

constexpr auto kLook = std::chrono::milliseconds(100);  // at most between two looks at whether to stop

}  // namespace

EmergencyStops::EmergencyStops(ros::NodeHandle node, const std::string& input, std::function<void()> changed)
    : changed_(std::move(changed)),
      by_input_(!input.empty()),  // pressed until the device says otherwise
      topic_(node.subscribe("emergency_stop", 10, &EmergencyStops::onTopic, this, ros::TransportHints().tcpNoDelay())) {
  if (!input.empty()) watch_ = std::thread([this, input] { watchInput(input); });
}

EmergencyStops::~EmergencyStops() {
  running_ = false;
  topic_.shutdown();
  if (watch_.joinable()) watch_.join();
}

void EmergencyStops::onTopic(const std_msgs::Bool::ConstPtr& message) {
  by_topic_ = message->data != 0;
  changed_();
}

void EmergencyStops::watchInput(const std::string& path) {
  EmergencyStopInput input(path);
  bool was_present = true;
  while (running_) {
    input.update(kLook);
    if (was_present && !input.present())
      ROS_WARN("emergency stop %s cannot be read: it counts as pressed", path.c_str());
    was_present = input.present();
    if (by_input_.exchange(input.pressed()) != input.pressed()) changed_();
  }
}

}  // namespace sinew
