#include "sinew/inverse/cycle_plan.h"

#include <algorithm>
#include <cmath>

#include "sinew/constraint/point_effector.h"

namespace sinew {
namespace {

// Far from its goal the error is large and the curvature of the reachable positions, which the linear problem does not
// see, decides over convergence: the change of effort is damped, and a gain too small to matter ends the chase.
constexpr double kFarGoalDamping = 0.3;   // of the best-driven direction
constexpr double kTakenBack = 0.5;        // cosine between two steps, below which the second takes back the first
constexpr double kOvershoot = 5;          // of a step, beyond which the next one is another chase
constexpr double kNegligibleGain = 2e-5;  // of the reach of one cycle

}  // namespace

CyclePlan::CyclePlan(const RobotModel& robot)
    : robot_(robot),
      goal_(robot.effectorRows()),
      search_(robot, robot.effectorRows()),
      piece_(robot.actuatorCount(), robot.effectorRows(), robot.maxContacts()),
      none_pressing_(static_cast<std::size_t>(robot.maxContacts()), 0),
      problem_(robot.actuatorCount(), robot.effectorRows(), robot.maxContacts()),
      data_(robot.actuatorCount(), robot.effectorRows(), robot.maxContacts()),
      result_(robot.actuatorCount()),
      contact_force_(VecX::Zero(robot.maxContacts())),
      contact_gap_(VecX::Zero(robot.maxContacts())),
      last_motion_(VecX::Zero(robot.actuatorCount() + robot.effectorRows())),
      gap_shift_(VecX::Zero(robot.maxContacts())),
      pushed_(VecX::Zero(robot.actuatorCount() + robot.effectorRows())),
      drift_(pushed_),
      row_motion_(VecX::Zero(robot.actuatorCount() + robot.effectorRows() + robot.maxContacts())) {}

void CyclePlan::recordStep(double scale) {
  const auto motion = row_motion_.head(drift_.size());
  const double length = motion.norm(), before = last_motion_.norm();
  const bool back = motion.dot(last_motion_) < -kTakenBack * length * before && length < kOvershoot * before;
  damping_.recordStep(scale * length, back && missed_ > length);
  last_motion_ = motion;
}

void CyclePlan::forget() {
  damping_.reset();
  last_motion_.setZero();
  problem_.forget();
  search_.forget();
  pressed_ = false;
}

// The rows of targeted effectors and their present error.
void CyclePlan::gatherRows(const CondensedRobot& robot, const CycleInput& input, bool held) {
  int row = robot.actuators();
  for (int e = 0; e < robot_.effectorCount(); ++e) {
    const PointEffector& effector = robot_.effectors()[e];
    const int count = effector.rowCount();
    if (input.targeted[e] && effector.description().hold == held) {
      double* const error = goal_.error.data() + goal_.rows.size();
      effector.calcError(robot.positions(), input.targets.segment<3>(3 * e), error);
      for (int k = 0; k < count; ++k) goal_.rows.push_back(row + k);
    }
    row += count;
  }
}

// All targeted effectors, those that hold first. A goal farther than the reach of one cycle is chased part of
// the way: one factor for all its rows keeps the stationary points. What the body would move by itself is added whole.
double CyclePlan::gatherGoal(const CondensedRobot& robot, const CycleInput& input, CycleOutput& output) {
  goal_.rows.clear();
  goal_.firm = true;
  gatherRows(robot, input, true);
  goal_.held = static_cast<int>(goal_.rows.size());
  gatherRows(robot, input, false);
  const int used = static_cast<int>(goal_.rows.size());
  const double reach = robot_.description().control.reach_per_cycle;
  const double distance = goal_.error.head(used).norm();
  const auto shorten = [reach](auto error) {
    const double length = error.norm(), share = length > reach ? reach / length : 1.0;
    error *= share;
    return share;
  };
  output.goal_scale =
      std::min(shorten(goal_.error.head(goal_.held)), shorten(goal_.error.segment(goal_.held, used - goal_.held)));
  for (int k = 0; k < used; ++k) goal_.error[k] += robot.freeMotion()[goal_.rows[k]];
  data_.negligible_gain = output.goal_scale < 1 ? kNegligibleGain * reach : 0;
  return distance;
}

bool CyclePlan::searchPiece(const CondensedRobot& robot, const ContactFinder& finder, const CycleInput& input,
                            const CycleLimits& limits, const VecX& effort, CycleOutput& output) {
  const SearchAllowance allowance{input.overload < OverloadLevel::kNoExploration, input.search_time};
  const double damping = calcDamping(output.goal_scale);
  QpccStatus status = search_.solve(robot, finder.list(), goal_, limits, effort, damping, allowance);
  if (status != QpccStatus::kSolved && goal_.held > 0) {
    goal_.firm = false;
    status = search_.solve(robot, finder.list(), goal_, limits, effort, damping, allowance);
  }
  const QpccSolution& found = search_.solution();
  output.contacts.proved_global = found.proved_global;
  output.contacts.declined_better = found.declined_better;
  output.contacts.out_of_time = found.deadline_ended;
  output.contacts.pieces += found.pieces;
  output.contacts.nodes += found.nodes;
  return (status == QpccStatus::kSolved || status == QpccStatus::kGivenWay) && piece_.reduce(robot, found.active);
}

// With efforts as they are the rows would move by what moving obstacles ask for, and by what the last step left.
void CyclePlan::updateDamping(const CondensedRobot& robot, const ContactFinder& finder) {
  if (pressed_ && contacts_ == 0) {  // what held the body is gone: no fault of the last step
    damping_.update(0, 0);
    return;
  }
  for (int i = 0; i < contacts_; ++i) gap_shift_[i] = finder.calcGapShift(i);
  piece_.calcResponse(gap_shift_, pushed_);
  drift_ = piece_.value().head(drift_.size()) - pushed_;
  drift_.head(robot.actuators()) -= robot.displacement();
  damping_.update(drift_.norm(), pushed_.norm());
}

double CyclePlan::calcDamping(double goal_scale) const {
  return robot_.description().control.smoothing + damping_.value() + kFarGoalDamping * (1 - goal_scale);
}

// The inverse problem within the present piece, contact forces eliminated.
void CyclePlan::gatherProblem(const CondensedRobot& robot, const VecX& effort, double goal_scale) {
  const int n = robot.actuators();
  data_.damping = calcDamping(goal_scale);
  data_.effector_rows = static_cast<int>(goal_.rows.size());
  data_.held_rows = goal_.held;
  data_.firm = goal_.firm;
  for (int k = 0; k < data_.effector_rows; ++k) {
    const int row = goal_.rows[k];
    data_.W_ea.row(k) = piece_.W().row(row);
    data_.effector_error[k] = goal_.error[k] + (piece_.value()[row] - robot.freeMotion()[row]);
  }
  data_.unit_compliance = robot.compliance().diagonal().head(n);
  data_.W_aa = piece_.W().topRows(n);
  data_.displacement = piece_.value().head(n);
  data_.effort = effort;
  data_.contacts = contacts_;
  data_.W_ca.topRows(contacts_) = piece_.W().bottomRows(contacts_);
  data_.contact.head(contacts_) = piece_.value().tail(contacts_);
  data_.contact_slack.head(contacts_).setZero();
}

// The search has found a point of the piece; rounding must not make it look impossible.
void CyclePlan::allowSearched() {
  const auto found = search_.solution().x.head(robot_.actuatorCount());
  for (int i = 0; i < contacts_; ++i) {
    data_.contact_slack[i] = std::max(0.0, -(data_.contact[i] + data_.W_ca.row(i).dot(found)));
  }
}

// Where the last digits fail the programme, the answer of the search stands.
bool CyclePlan::solveProblem(const CycleLimits& limits, CycleOutput& output) {
  output.qp_status = problem_.solve(data_, limits, result_);
  output.qp_iterations += result_.iterations;
  if (output.qp_status == QpStatus::kSolved) return true;
  if (contacts_ == 0 || search_.solution().status != QpccStatus::kSolved) return false;
  result_.effort_change = search_.solution().x.head(robot_.actuatorCount());
  result_.effort_violation.setZero();
  return true;
}

void CyclePlan::calcMotion(const CondensedRobot& robot) {
  piece_.calcContacts(result_.effort_change, contact_force_, contact_gap_);
  auto motion = row_motion_.head(robot.rows());
  motion = robot.freeMotion();
  motion.noalias() += robot.compliance().leftCols(robot.actuators()) * result_.effort_change;
  motion.noalias() += robot.compliance().rightCols(contacts_) * contactForce();
  double squared = 0;
  for (std::size_t k = 0; k < goal_.rows.size(); ++k) {
    const int row = goal_.rows[k];
    squared += std::pow(goal_.error[k] - robot.freeMotion()[row] + motion[row], 2);
  }
  missed_ = std::sqrt(squared);
}

HoldReason CyclePlan::make(const CondensedRobot& robot, const ContactFinder& finder, const CycleInput& input,
                           const CycleLimits& limits, const VecX& effort, CycleOutput& output) {
  if (!std::isfinite(gatherGoal(robot, input, output))) return HoldReason::kNotFinite;
  contacts_ = robot.contacts();
  if (contacts_ == 0) {
    piece_.reduce(robot, none_pressing_);
  } else if (!searchPiece(robot, finder, input, limits, effort, output)) {
    return HoldReason::kQpFailed;
  }
  if (!output.repeats) updateDamping(robot, finder);
  gatherProblem(robot, effort, output.goal_scale);
  if (contacts_ > 0) allowSearched();
  if (!solveProblem(limits, output)) return HoldReason::kQpFailed;
  calcMotion(robot);
  pressed_ = (contactForce().array() > 0).any();
  return HoldReason::kNone;
}

}  // namespace sinew
