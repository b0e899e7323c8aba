#include "simulated_devices.h"

#include <ros/console.h>

#include <exception>

namespace sinew {

SimulatedDevicesDesk::SimulatedDevicesDesk(ros::NodeHandle node, ros::NodeHandle private_node,
                                           const HardwareDescription& description, const LineFaults& line)
    : hardware_(description),
      faults_(hardware_, line, [this](int bus, double time) { disconnect(bus, time); }),
      node_(node),
      reconnect_timers_(description.buses.size()),
      state_(node.advertise<SimulatedDevices>("plant/devices", 100)) {
  message_.name = description.names();
  for (const Quantity quantity : description.quantities()) message_.mode.push_back(static_cast<std::uint8_t>(quantity));
  message_.value.resize(message_.name.size());
  message_.energised.resize(message_.name.size());
  message_.snapped.resize(message_.name.size());
  for (int bus = 0; bus < hardware_.buses(); ++bus) connect(bus);
  inject_ = private_node.advertiseService("inject", &SimulatedDevicesDesk::onInject, this);
}

void SimulatedDevicesDesk::connect(int bus) {
  hardware_.connect(bus);
  ROS_INFO("devices answer at %s", hardware_.port(bus).c_str());
}

void SimulatedDevicesDesk::disconnect(int bus, double time) {
  hardware_.disconnect(bus);
  const auto reconnect = [this, bus](const ros::WallTimerEvent&) {
    try {
      connect(bus);
    } catch (const std::exception& error) {
      ROS_ERROR("the line stays away: %s", error.what());
    }
  };
  reconnect_timers_[static_cast<std::size_t>(bus)] = node_.createWallTimer(ros::WallDuration(time), reconnect, true);
}

bool SimulatedDevicesDesk::onInject(InjectFault::Request& request, InjectFault::Response& response) {
  const FaultDesk::Answer answer = faults_.inject(request.fault, request.actuator, request.value);
  response.success = answer.success;
  response.message = answer.message;
  if (answer.success) ROS_INFO("injected: %s", answer.message.c_str());
  return true;
}

void SimulatedDevicesDesk::publish(ros::Time stamp) {
  message_.header.stamp = stamp;
  for (int i = 0; i < hardware_.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool pressure = message_.mode[k] == static_cast<std::uint8_t>(Quantity::kPressure);
    message_.value[k] = pressure ? hardware_.pressure(i) : hardware_.reeledIn(i);
    message_.energised[k] = hardware_.energised(i);
    message_.snapped[k] = hardware_.snapped(i);
  }
  state_.publish(message_);
}

}  // namespace sinew
