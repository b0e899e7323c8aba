#pragma once

#include <ros/node_handle.h>

#include <cstdint>
#include <string>
#include <vector>

#include "simulated_robot_node_plant.h"
#include "simulated_robot_node_tracker.h"
#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/line_faults.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

/// The private parameters of the simulated robot.
struct SimulatedRobotSettings {
  RobotDescription robot;
  PlantDeviations deviations;
  HardwareDescription hardware;
  std::vector<int> winches;  ///< per actuator of the robot: which one of the hardware moves it
  LineFaults line;
  double plant_rate = 100;   ///< Hz
  double display_rate = 15;  ///< Hz
  SimulatedTracker::Parameters tracker;
};

/// Throws ConfigError that names parameter or file, what is there and what would be right.
SimulatedRobotSettings readSimulatedRobotSettings(const ros::NodeHandle& private_node);

}  // namespace sinew
