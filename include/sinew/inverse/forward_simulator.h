#pragma once

#include <memory>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/inverse/forward_step.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

/// The robot as physics moves it: actuation in, configuration out. Same model and elements as the controller.
class ForwardSimulator {
 public:
  /// `steps_per_factor`: near rest, a static robot's tangent is factorised anew in one step out of so many.
  explicit ForwardSimulator(std::shared_ptr<const RobotModel> robot, int steps_per_factor = 1);
  ~ForwardSimulator();

  Actuation makeActuation() const;

  /// One linearised step of `period` [s]; quasi-static or dynamic as the robot's description says.
  ForwardStatus step(const Actuation& actuation, double period);

  /// Steps until the residual is below `tolerance` relative to the load, `max_steps` at most.
  ForwardStatus settle(const Actuation& actuation, double tolerance = 1e-9, int max_steps = 200);

  void reset();

  /// Where the obstacles are from now on, in the order of the robot's description.
  void setObstacles(const std::vector<ObstacleState>& obstacles);

  const std::vector<Vec3>& nodes() const;                            ///< m, present positions
  void calcCablePoints(int cable, std::vector<Vec3>& points) const;  ///< m, pull point first
  const VecX& displacement() const;     ///< per actuator [m], of the cables in the present configuration
  const VecX& effort() const;           ///< per actuator [N]
  const VecX& effectors() const;        ///< 3 x effectors [m]
  const ContactList& contacts() const;  ///< as found at the start of the last step
  Eigen::VectorBlock<const VecX> contactForce() const;  ///< N, of these contacts
  double residual() const;                              ///< N
  double residualRelative() const;                      ///< 1

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
