#pragma once

#include <memory>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/robot_model.h"
#include "sinew/inverse/stage_times.h"
#include "sinew/solver/dense_qp.h"

namespace sinew {

enum class CycleStatus {
  kSolved,    ///< the command solves this cycle's problem within every limit
  kDegraded,  ///< solved, but an effort limit had to give way; see the active limits
  kHeld       ///< not solved: the command repeats the last valid one
};

enum class HoldReason { kNone, kNotFinite, kNotPositiveDefinite, kQpFailed };

/// Which side of which limit the solution sits on; the order is that of ActiveLimit.msg.
enum class LimitKind { kDisplacementMin, kDisplacementMax, kEffortMin, kEffortMax, kRateMin, kRateMax };

struct ActiveLimitReport {
  int actuator = 0;
  LimitKind kind = LimitKind::kDisplacementMin;
  double value = 0;      ///< m, N or these per s
  double violation = 0;  ///< by how much it gave way, 0 when kept
};

/// How the contacts of a cycle were answered; the forces and gaps belong to `InverseController::contacts()`.
struct ContactReport {
  int count = 0;
  VecX force, gap;               ///< N, m, at the solution of the linear problem; the leading `count` entries
  bool proved_global = false;    ///< no better choice of pressing contacts exists
  bool declined_better = false;  ///< a better but far choice was left
  int pieces = 0, nodes = 0;     ///< that the search solved
};

/// What a cycle reads. Sizes are those of the robot: three coordinates an effector, one value an actuator.
struct CycleInput {
  VecX targets;                ///< 3 x effectors [m], robot frame
  std::vector<bool> targeted;  ///< per effector: false leaves it free until its first target arrives
  /// Where the obstacles are [m], robot frame, in the order of the robot's description; a missing tail stays as it was.
  std::vector<ObstacleState> obstacles;
  VecX applied;          ///< per actuator [m]: displacement that the driver applied last; size 0 when nobody tells
  double period = 0.01;  ///< s
};

/// What a cycle gives back, sized at set-up.
struct CycleOutput {
  CycleStatus status = CycleStatus::kHeld;
  HoldReason reason = HoldReason::kNone;
  VecX displacement;             ///< per actuator [m]: the command
  VecX effort;                   ///< per actuator [N]
  VecX effectors;                ///< 3 x effectors [m], as modelled after the step
  double effector_error = 0;     ///< m, weighted norm over the targeted, controlled axes
  double goal_scale = 1;         ///< 1 when the goal is chased whole
  double residual = 0;           ///< N, norm of the unbalanced force at the new configuration
  double residual_relative = 0;  ///< residual over the norm of the load
  std::vector<ActiveLimitReport> limits;
  ContactReport contacts;
  int qp_iterations = 0;
  QpStatus qp_status = QpStatus::kSolved;
  int newton_steps = 0;
  StageTimes times;
};

/// Finds, every cycle, the cable displacements that bring the effectors nearest to their targets, and among equal ones
/// those of least potential energy (thesis 3.3). The plan is quasi-static; in a dynamic robot a second body follows the
/// commands with inertia and damping, and is what the effectors and nodes report. The model integrates its own state.
class InverseController {
 public:
  explicit InverseController(std::shared_ptr<const RobotModel> robot);
  ~InverseController();

  const RobotModel& robot() const;
  CycleInput makeInput() const;
  CycleOutput makeOutput() const;

  /// Linearises and factorises ahead what the next `step` starts from, which is nearly all of its work and does not
  /// depend on its input, so that the command follows its targets without delay. Adds to the output's times.
  void prepare(CycleOutput& output);

  /// One control cycle. Never throws; on failure the output holds the last valid command with the reason.
  CycleStatus step(const CycleInput& input, CycleOutput& output);

  /// Moves the model to the measured displacements [m] by solving the forward problem, over as many load steps as it
  /// takes. Returns the largest remaining difference between measured and modelled displacement of a taut cable [m]
  /// or infinity when no equilibrium is found. Not for the cycle path.
  double resynchronise(const VecX& measured);

  /// Advances the model with the displacements [m] held: what a disabled controller does every cycle.
  CycleStatus follow(const VecX& displacement, double period, CycleOutput& output);

  /// Back to rest: no displacement, no effort.
  void reset();

  const std::vector<Vec3>& nodes() const;                            ///< m, present positions
  const ContactList& contacts() const;                               ///< of the last cycle, as found at its start
  void calcCablePoints(int cable, std::vector<Vec3>& points) const;  ///< m, pull point first

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
