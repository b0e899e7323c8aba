#pragma once

#include <ros/node_handle.h>
#include <sinew/InjectFault.h>
#include <sinew/SimulatedDevices.h>

#include <vector>

#include "simulated_robot_node_faults.h"
#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/simulated_hardware.h"

namespace sinew {

/// Simulated devices as ROS sees them: lines that come and go, faults by service (~inject), and what they really do
/// (plant/devices).
class SimulatedDevicesDesk {
 public:
  /// Lines are up when it is made. Throws ConfigError.
  SimulatedDevicesDesk(ros::NodeHandle node, ros::NodeHandle private_node, const HardwareDescription& description,
                       const LineFaults& line);

  SimulatedHardware& hardware() { return hardware_; }
  FaultDesk& faults() { return faults_; }
  void publish(ros::Time stamp);

 private:
  void connect(int bus);
  void disconnect(int bus, double time);
  bool onInject(InjectFault::Request& request, InjectFault::Response& response);

  SimulatedHardware hardware_;
  FaultDesk faults_;
  ros::NodeHandle node_;
  std::vector<ros::WallTimer> reconnect_timers_;  // one per bus
  ros::Publisher state_;
  SimulatedDevices message_;
  ros::ServiceServer inject_;
};

}  // namespace sinew
