#pragma once

#include <ros/node_handle.h>

#include <cstdint>
#include <string>
#include <vector>

#include "simulated_robot_node_plant.h"
#include "simulated_robot_node_tracker.h"
#include "simulated_robot_node_winches.h"
#include "sinew/hardware/line_faults.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

/// The private parameters of the simulated robot.
struct SimulatedRobotSettings {
  RobotDescription robot;
  PlantDeviations deviations;
  std::vector<Winch> winches;  ///< in the order of the robot's cables
  int baud = 1000000;
  LineFaults line;
  std::string port_link;     ///< where the driver finds its port; empty for none
  double plant_rate = 100;   ///< Hz
  double display_rate = 15;  ///< Hz
  SimulatedTracker::Parameters tracker;

  std::vector<std::uint8_t> ids() const;
  std::vector<std::string> actuators() const;
};

/// Throws ConfigError that names parameter or file, what is there and what would be right.
SimulatedRobotSettings readSimulatedRobotSettings(const ros::NodeHandle& private_node);

}  // namespace sinew
