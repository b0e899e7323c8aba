#pragma once

#include <memory>
#include <vector>

#include "sinew/inverse/forward_simulator.h"
#include "sinew/inverse/robot_model.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

/// How the robot that is built differs from the one that was drawn.
struct PlantDeviations {
  double stiffness_factor = 1;     ///< 1, on every Young's modulus
  double gravity_tilt = 0;         ///< rad, the mounting turned about the robot frame's x axis
  std::vector<double> cable_zero;  ///< m per actuator: reeled in when the servo stands at its zero; empty for none
};

/// The description of the robot as built. Throws ConfigError when a deviation makes no sense.
RobotDescription makeDeviated(const RobotDescription& drawn, const PlantDeviations& deviations);

/// The body that the servos pull at: one linearised step of the forward model per period.
class SimulatedPlant {
 public:
  /// Hangs at rest, servos at their zeros. Throws ConfigError when the body finds no equilibrium.
  SimulatedPlant(const RobotDescription& drawn, const PlantDeviations& deviations);

  const RobotModel& robot() const { return *robot_; }
  const std::shared_ptr<const RobotModel>& sharedRobot() const { return robot_; }

  /// Where the obstacles are from the next step on, in the order of the robot's description.
  void setObstacles(const std::vector<ObstacleState>& obstacles) { simulator_.setObstacles(obstacles); }

  /// A snapped cable pulls at nothing.
  void setSnapped(int actuator, bool snapped);

  /// Moves on by `period` [s] with `reeled_in` [m per actuator, by the servos' angles]. A step that fails leaves the
  /// body where it was, or at rest when nothing finite is left of it, and is counted.
  void step(const VecX& reeled_in, double period);

  const ForwardSimulator& simulator() const { return simulator_; }
  unsigned long failedSteps() const { return failed_steps_; }

 private:
  void settle();

  std::shared_ptr<const RobotModel> robot_;
  ForwardSimulator simulator_;
  Actuation actuation_;
  VecX cable_zero_;  // m
  std::vector<bool> snapped_;
  unsigned long failed_steps_ = 0;
};

}  // namespace sinew
