#pragma once

#include <memory>
#include <vector>

#include "sinew/body/fem_body.h"
#include "sinew/constraint/constraint_rows.h"
#include "sinew/inverse/robot_model.h"
#include "sinew/inverse/stage_times.h"

namespace sinew {

/// The robot linearised and condensed to its constraints: the body moves by dx = dx_free + A^-1 H_a^T d_effort, where
/// "free" leaves the efforts as they are, so a row changes from its present value by
///   H dx = free + W_(row, actuators) d_effort,   W = H A^-1 H^T.
/// Rows are the actuators, in order, then the effectors' controlled axes.
class CondensedRobot {
 public:
  explicit CondensedRobot(std::shared_ptr<const RobotModel> robot);

  const RobotModel& robot() const { return *robot_; }
  FemBody& body() { return body_; }
  const FemBody& body() const { return body_; }
  int actuators() const { return actuators_; }
  int rows() const { return rows_.rows(); }

  StepRule makeRule(double period) const;

  /// Assembles forces, load stiffness and rows at the present configuration with `effort` [N]; updates the present
  /// values.
  void linearise(const VecX& effort, const StepRule& rule, StageTimes& times);
  /// The same with the tangent and factor of an earlier `condense`, for a static step: a modified Newton step.
  void relinearise(const VecX& effort, StageTimes& times);
  /// Factorises and condenses. Where the exact tangent is indefinite (a body near buckling) the semi-definite one takes
  /// its place, with the cost of a second assembly; false when even that is not positive definite.
  bool condense(StageTimes& times);
  /// Condenses with the factor of an earlier `condense`.
  void recondense(StageTimes& times);

  const MatX& compliance() const { return compliance_; }      ///< W, rows x rows [m/N]
  const VecX& freeMotion() const { return free_motion_; }     ///< H dx_free, one per row [m]
  const VecX& displacement() const { return displacement_; }  ///< delta_a at the linearisation, per actuator [m]
  double residual() const { return residual_; }               ///< N, unbalanced force at the linearisation
  double loadNorm() const { return load_norm_; }              ///< N, gravity and cables', never 0

  /// Moves the body for a change of the efforts [N]; returns the scale <= 1 that was applied to motion and change.
  double advance(const VecX& effort_change, double max_node_step, StageTimes& times);

  void reset();

 private:
  void assembleSystem(Tangent tangent);
  void addActuators(bool with_stiffness);
  bool factorise(StageTimes& times);

  std::shared_ptr<const RobotModel> robot_;
  FemBody body_;
  ConstraintRows rows_;
  int actuators_;
  MatX half_;  // Y = L^-1 P [H^T b]
  MatX compliance_;
  VecX effort_, free_motion_, displacement_, cable_force_, half_motion_, motion_;
  StepRule rule_;
  double negligible_load_;  // N
  double residual_ = 0, load_norm_ = 0;
};

}  // namespace sinew
