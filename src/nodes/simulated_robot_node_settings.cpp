#include "simulated_robot_node_settings.h"

#include <algorithm>
#include <random>

#include "parameters.h"

namespace sinew {
namespace {

/// The actuator of the hardware behind each of the robot's cables; a carrier's is the pinion of its rail.
std::vector<int> findWinches(const RobotDescription& robot, const HardwareDescription& hardware,
                             const Parameters& parameters) {
  std::vector<int> winches;
  const std::vector<std::string> names = hardware.names();
  for (const ActuatorLimits& driven : listActuators(robot)) {
    const auto found = std::find(names.begin(), names.end(), driven.name);
    if (found == names.end()) {
      parameters.fail("hardware", "no actuator '" + driven.name + "' in it",
                      "one actuator per cable of the robot, and one for its carrier");
    }
    winches.push_back(static_cast<int>(found - names.begin()));
  }
  return winches;
}

/// The list `zero_offset` plus an even random share of `cable_zero_error` per cable.
std::vector<double> readCableZeros(const Parameters& parameters, const ros::NodeHandle& node, size_t cables,
                                   std::uint32_t seed) {
  std::vector<double> zeros(cables, 0.0);
  if (parameters.has("zero_offset") && (!node.getParam("zero_offset", zeros) || zeros.size() != cables)) {
    parameters.fail("zero_offset", std::to_string(zeros.size()) + " values or something else than a list",
                    "a list of " + std::to_string(cables) + " numbers [m], one per cable");
  }
  const double error = parameters.numberOr("cable_zero_error", 0, 0, 1);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-1, 1);
  for (double& zero : zeros) zero += error * share(random);
  return zeros;
}

LineFaults readLineFaults(const Parameters& parameters, std::uint32_t seed) {
  LineFaults line;
  line.corrupt = parameters.numberOr("line/corrupt", 0, 0, 1);
  line.drop = parameters.numberOr("line/drop", 0, 0, 1 - line.corrupt);
  line.delay = parameters.numberOr("line/delay", 0, 0, 1 - line.corrupt - line.drop);
  line.duplicate = parameters.numberOr("line/duplicate", 0, 0, 1 - line.corrupt - line.drop - line.delay);
  line.delay_time = parameters.numberOr("line/delay_time", line.delay_time, 0, 10);
  line.seed = seed;
  return line;
}

SimulatedTracker::Parameters readTracker(const Parameters& parameters, std::uint32_t seed) {
  SimulatedTracker::Parameters tracker;
  tracker.rate = parameters.numberOr("tracker_rate", tracker.rate, 0.1, 2000);
  tracker.latency = parameters.numberOr("tracker_latency", tracker.latency, 0, 10);
  tracker.noise = parameters.numberOr("tracker_noise", tracker.noise, 0, 1);
  tracker.seed = seed;
  return tracker;
}

}  // namespace

SimulatedRobotSettings readSimulatedRobotSettings(const ros::NodeHandle& private_node) {
  const Parameters parameters(private_node);
  const auto seed = static_cast<std::uint32_t>(parameters.integerOr("seed", 1, 0, 1 << 30));
  SimulatedRobotSettings settings;
  settings.hardware = HardwareDescription::load(parameters.text("hardware"));
  if (parameters.has("port_link")) settings.hardware.movePorts(parameters.text("port_link"));
  settings.robot = readRobotDescription(parameters.text("robot"));
  settings.winches = findWinches(settings.robot, settings.hardware, parameters);
  settings.deviations.stiffness_factor = parameters.numberOr("stiffness_factor", 1, 1e-3, 1e3);
  settings.deviations.gravity_tilt = parameters.numberOr("gravity_tilt", 0, -7, 7);
  settings.deviations.cable_zero = readCableZeros(parameters, private_node, settings.winches.size(), seed);
  settings.line = readLineFaults(parameters, seed);
  settings.plant_rate = parameters.numberOr("plant_rate", settings.plant_rate, 1, 1000);
  settings.display_rate = parameters.numberOr("display_rate", settings.display_rate, 0.1, 1000);
  settings.tracker = readTracker(parameters, seed);
  return settings;
}

}  // namespace sinew
