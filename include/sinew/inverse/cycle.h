#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/inverse/obstacle.h"
#include "sinew/inverse/stage_times.h"
#include "sinew/solver/qp_problem.h"

namespace sinew {

enum class CycleStatus {
  kSolved,    ///< the command solves this cycle's problem within every limit
  kDegraded,  ///< solved, but an effort limit had to give way, see the active limits, or an effector could not be held,
              ///< or contacts that are near found no room, or something was left out for want of time
  kHeld       ///< not solved: the command repeats the last valid one
};

/// What a cycle leaves out to be in time, each with all before it, in the order in which it is missed least.
enum class OverloadLevel {
  kNone,
  kOneNewtonStep,       ///< a single linearisation
  kNoExploration,       ///< with contacts: only the descent from the last answer
  kSharedLinearisation  ///< cycles share a linearisation, its contacts among it, see `InverseController::renew`
};
constexpr OverloadLevel kHighestOverload = OverloadLevel::kSharedLinearisation;
constexpr int kOverloadLevels = static_cast<int>(kHighestOverload) + 1;

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
  bool crowded = false;          ///< contacts in the nearer half of what is watched found no room
  bool proved_global = false;    ///< no better choice of pressing contacts exists
  bool declined_better = false;  ///< a better but far choice was left
  bool out_of_time = false;      ///< the search ended for its time, not for its counts
  int pieces = 0, nodes = 0;     ///< that the search solved
};

/// What a cycle reads. Sizes are those of the robot: three coordinates an effector, one value an actuator.
struct CycleInput {
  VecX targets;                ///< 3 x effectors [m], robot frame
  std::vector<bool> targeted;  ///< per effector: false leaves it free until its first target arrives
  /// Where the obstacles are [m], robot frame, in the order of the robot's description; a missing tail stays as it was.
  std::vector<ObstacleState> obstacles;
  VecX by_hand;          ///< per actuator [m]: displacement that somebody else gives it, NaN for none; size 0 likewise
  VecX applied;          ///< per actuator [m]: displacement that the driver applied last; size 0 when nobody tells
  double period = 0.01;  ///< s
  OverloadLevel overload = OverloadLevel::kNone;
  double search_time = 0;  ///< s for the search among contacts, besides what the description allows; 0 for no bound
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
  bool holds = true;             ///< whether the effectors that are to hold can, in the linear problem
  double residual = 0;           ///< N, norm of the unbalanced force at the new configuration
  double residual_relative = 0;  ///< residual over the norm of the load
  std::vector<ActiveLimitReport> limits;
  ContactReport contacts;
  int qp_iterations = 0;
  QpStatus qp_status = QpStatus::kSolved;
  int newton_steps = 0;
  OverloadLevel overload = OverloadLevel::kNone;  ///< what the cycle left out
  bool repeats = false;                           ///< an earlier cycle was answered with the same linearisation
  int linearisation_age = 0;                      ///< cycles since the robot stood where it is linearised
  StageTimes times;
};

}  // namespace sinew
