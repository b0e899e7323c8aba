#pragma once

#include <memory>
#include <vector>

#include "sinew/body/carrier.h"
#include "sinew/body/fem_body.h"
#include "sinew/constraint/constraint_rows.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/contact_stiffness.h"
#include "sinew/inverse/robot_model.h"
#include "sinew/inverse/stage_times.h"

namespace sinew {

/// The robot linearised and condensed to its constraints: the body moves by dx = dx_free + A^-1 H_a^T d_effort, where
/// "free" leaves the efforts as they are, so a row changes from its present value by
///   H dx = free + W_(row, actuators) d_effort + W_(row, contacts) contact force,   W = H A^-1 H^T.
/// Rows are the actuators, in order, the effectors' controlled axes, then the contacts. Efforts are solved in changes,
/// contact forces as totals. A cycle is linearise, factorise, addContacts (none if left out), condense, advance.
///
/// A carrier is one more degree of freedom, on a spring of compliance c that is relaxed at the present travel s:
///   ds = c (effort + sum of force d gap / ds),   W += c r r^T,   r = d row / ds.
/// Its effort is then the force that contacts ask of the drive. Since the travel is what is planned or given, c drops
/// out of every answer; it only makes the carrier one actuator among others.
class CondensedRobot {
 public:
  explicit CondensedRobot(std::shared_ptr<const RobotModel> robot);

  const RobotModel& robot() const { return *robot_; }
  FemBody& body() { return body_; }
  const FemBody& body() const { return body_; }
  /// m, every mesh node in the robot's frame; those of `body()` travel with the carrier.
  const std::vector<Vec3>& positions() const { return robot_->hasCarrier() ? positions_ : body_.positions(); }
  Vec3 offset() const { return carrier_.offset(); }                  ///< m, by which the two differ
  void calcCablePoints(int cable, std::vector<Vec3>& points) const;  ///< m, pull point first
  void calcDisplacement(VecX& displacement) const;                   ///< per actuator [m], in the present configuration
  int actuators() const { return actuators_; }
  int contacts() const { return static_cast<int>(gap_size_); }
  int firstContact() const { return actuators_ + effector_rows_; }  ///< row
  int rows() const { return rows_.rows(); }

  StepRule makeRule(double period) const;

  /// As of `FemBody`, with the carrier.
  void beginStep();
  void endStep(const StepRule& rule);
  void abandonStep();
  /// For a dynamic step, between `beginStep` and `linearise`: the carrier will be at `travel` [m] when it ends.
  void accelerateCarrier(double travel, const StepRule& rule);
  /// At rest in the configuration of `other`, a robot of the same model.
  void place(const CondensedRobot& other);
  /// The same with the contacts that press on `other`, and the stiffness that they give.
  void imitate(const CondensedRobot& other);

  /// Assembles forces, load stiffness and rows at the present configuration with `effort` [N]; updates the present
  /// values.
  void linearise(const VecX& effort, const StepRule& rule, StageTimes& times);
  /// The same with the tangent and factor of an earlier `factorise`, for a static step: a modified Newton step.
  void relinearise(const VecX& effort, StageTimes& times);
  /// Where the exact tangent is indefinite (a body near buckling) the semi-definite one takes its place, with the cost
  /// of a second assembly; false when even that is not positive definite.
  bool factorise(StageTimes& times);
  /// Rows of the contacts that `finder` has found at the present configuration.
  void addContacts(const ContactFinder& finder);
  void condense(StageTimes& times);
  /// The obstacles have moved by what the finder's last `setObstacles` says: gaps follow, normals stay.
  void shiftGaps(const ContactFinder& finder);

  auto compliance() const { return compliance_.topLeftCorner(rows(), rows()); }  ///< W [m/N]
  auto freeMotion() const { return free_motion_.head(rows()); }                  ///< H dx_free, one per row [m]
  auto gap() const { return gap_.head(contacts()); }                             ///< of the contacts, as found [m]
  const VecX& displacement() const { return displacement_; }  ///< delta_a at the linearisation, per actuator [m]
  /// N, unbalanced force at the linearisation; contacts press as they were last solved.
  double residual() const { return residual_; }
  double roundingForce() const { return rounding_force_; }  ///< N, below which a residual says nothing
  double loadNorm() const { return load_norm_; }            ///< N, gravity, cables' and contacts', never 0

  /// Moves the body for a change of the efforts and for contact forces [N]; returns the scale <= 1 that was applied to
  /// motion and change.
  double advance(const VecX& effort_change, const Eigen::Ref<const VecX>& contact_force, double max_node_step,
                 StageTimes& times);
  /// What `effort` [N] has become by an `advance` that returned `scale`: the carrier's spring is relaxed again.
  void updateEffort(const VecX& effort_change, const Eigen::Ref<const VecX>& contact_force, double scale,
                    VecX& effort) const;

  void reset();

 private:
  void assembleSystem(Tangent tangent);
  void addActuators(bool with_stiffness);
  void condenseCarrier();
  double calcCarrierMotion(const VecX& effort_change, const Eigen::Ref<const VecX>& contact_force) const;
  void updatePositions();

  std::shared_ptr<const RobotModel> robot_;
  FemBody body_;
  Carrier carrier_;
  std::vector<Vec3> positions_;  // m, robot's frame, of a robot with a carrier
  ConstraintRows rows_;
  int actuators_, effector_rows_;
  MatX compliance_;
  VecX carrier_half_;              // sqrt(c) [r, effort]: what the carrier adds to L^-1 [H^T b]
  double carrier_compliance_ = 0;  // c, m/N
  VecX effort_, free_motion_, displacement_, gap_, cable_force_, contact_force_, row_force_, motion_;
  Eigen::Index gap_size_ = 0;
  const ContactFinder* finder_ = nullptr;  // of the contact rows
  ContactStiffness contact_stiffness_;
  StepRule rule_;
  double negligible_load_, rounding_force_;  // N
  double residual_ = 0, load_norm_ = 0;
};

}  // namespace sinew
