#include "sinew/inverse/contact_search.h"

#include <algorithm>
#include <chrono>
#include <limits>

namespace sinew {
namespace {

// Weights of the energy and of the change of effort, relative to the best-driven direction: they choose among pieces
// that reach the target alike.
constexpr double kEnergy = 1e-6;
constexpr double kRegularisation = 1e-8;

constexpr int kHurriedElasticRestarts = 4;  // where nothing else is explored

constexpr double kCarrierForce = 1e4;  // N, more than any contact asks of the drive: proofs want bounded unknowns

QpccSizes makeSizes(const RobotModel& robot, int max_effector_rows) {
  const int n = robot.actuatorCount();
  return {n, n + max_effector_rows, max_effector_rows, std::max(1, robot.maxContacts())};
}

}  // namespace

ContactSearch::ContactSearch(const RobotModel& robot, int max_effector_rows)
    : robot_(robot),
      problem_(makeSizes(robot, max_effector_rows)),
      guess_(makeSizes(robot, max_effector_rows)),
      solution_(makeSizes(robot, max_effector_rows)),
      solver_(makeSizes(robot, max_effector_rows)) {
  pressing_keys_.reserve(static_cast<std::size_t>(std::max(1, robot.maxContacts())));
}

void ContactSearch::forget() {
  known_ = false;
  pressing_keys_.clear();
  solver_.forget();
}

void ContactSearch::gather(const CondensedRobot& robot, const EffectorGoal& goal, const CycleLimits& limits,
                           const VecX& effort, double damping) {
  const auto W = robot.compliance();
  const int n = robot.actuators(), c = robot.contacts(), first = robot.firstContact();
  const int held = goal.equalities(), e = static_cast<int>(goal.rows.size()) - held;
  QpccProblem& p = problem_;
  p.resize({n, n + held, e, c});
  for (int k = 0; k < e; ++k) {
    const double weight = goal.weightOf(held + k);
    p.E_a.row(k).head(n) = weight * W.row(goal.rows[held + k]).head(n);
    p.E_c.row(k).head(c) = weight * W.row(goal.rows[held + k]).segment(first, c);
    p.e[k] = weight * goal.error[held + k];
  }
  double best = 0;
  for (int i = 0; i < n; ++i) {
    double gain = 0;
    for (const int row : goal.rows) gain += W(row, i) * W(row, i);
    best = std::max(best, gain / W(i, i));
  }
  p.Q.topLeftCorner(n, n) = best * kEnergy * W.topLeftCorner(n, n);
  p.q.head(n).noalias() = p.Q.topLeftCorner(n, n) * effort;
  for (int i = 0; i < n; ++i) p.Q(i, i) += best * (kRegularisation + damping) * W(i, i);
  p.x_lower.head(n).setConstant(-std::numeric_limits<double>::infinity());
  p.x_upper.head(n).setConstant(std::numeric_limits<double>::infinity());
  p.soft_lower.head(n) = limits.effort_min - effort;
  p.soft_upper.head(n) = limits.effort_max - effort;
  p.A_a.topLeftCorner(n, n) = W.topLeftCorner(n, n);
  p.A_c.topLeftCorner(n, c) = W.block(0, first, n, c);
  p.a.head(n) = robot.displacement() + robot.freeMotion().head(n);
  p.row_lower.head(n) = limits.displacement_min;
  p.row_upper.head(n) = limits.displacement_max;
  if (robot_.hasCarrier()) {
    const double way = limits.displacement_max[n - 1] - limits.displacement_min[n - 1];
    p.x_upper[n - 1] = kCarrierForce + way / W(n - 1, n - 1);
    p.x_lower[n - 1] = -p.x_upper[n - 1];
  }
  for (int k = 0; k < held; ++k) {
    p.A_a.row(n + k).head(n) = W.row(goal.rows[k]).head(n);
    p.A_c.row(n + k).head(c) = W.row(goal.rows[k]).segment(first, c);
    p.a[n + k] = goal.error[k];
    p.row_lower[n + k] = p.row_upper[n + k] = 0;
  }
  p.C_a.topLeftCorner(c, n) = W.block(first, 0, c, n);
  p.C_c.topLeftCorner(c, c) = W.block(first, first, c, c);
  p.c.head(c) = robot.gap() + robot.freeMotion().segment(first, c);
}

void ContactSearch::recall(const CondensedRobot& robot, const ContactList& contacts, const VecX& effort) {
  const int n = robot.actuators();
  const ControlDescription& control = robot_.description().control;
  guess_.valid = known_;
  guess_.x.setZero();
  guess_.row.head(n) = robot.displacement();
  guess_.reach.setConstant(std::numeric_limits<double>::infinity());
  guess_.reach.head(n).setConstant(control.switching_reach);
  guess_.margin = control.switching_margin;
  guess_.offset = 0.5 * problem_.q.head(n).dot(effort);  // the energy of the present efforts
  for (int i = 0; i < contacts.size(); ++i) {
    guess_.active[i] = std::binary_search(pressing_keys_.begin(), pressing_keys_.end(), contacts.row(i).key);
  }
}

void ContactSearch::remember(const ContactList& contacts) {
  pressing_keys_.clear();
  for (int i = 0; i < contacts.size(); ++i) {
    if (solution_.active[i]) pressing_keys_.push_back(contacts.row(i).key);
  }
  known_ = true;
}

QpccBudget ContactSearch::makeBudget(const SearchAllowance& allowance) const {
  using Clock = std::chrono::steady_clock;
  const ControlDescription& control = robot_.description().control;
  QpccBudget budget;
  budget.max_pieces = control.max_pieces;
  budget.max_nodes = control.max_nodes;
  if (!allowance.explores) {
    budget.max_nodes = budget.restarts = 0;
    budget.elastic_restarts = kHurriedElasticRestarts;
  }
  for (const double seconds : {control.search_time, allowance.time}) {
    if (seconds <= 0) continue;
    const auto time = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    budget.deadline = std::min(budget.deadline, Clock::now() + time);
  }
  return budget;
}

QpccStatus ContactSearch::solve(const CondensedRobot& robot, const ContactList& contacts, const EffectorGoal& goal,
                                const CycleLimits& limits, const VecX& effort, double damping,
                                const SearchAllowance& allowance) {
  gather(robot, goal, limits, effort, damping);
  recall(robot, contacts, effort);
  const QpccStatus status = solver_.solve(problem_, guess_, makeBudget(allowance), solution_);
  if (status == QpccStatus::kSolved || status == QpccStatus::kGivenWay) remember(contacts);
  return status;
}

}  // namespace sinew
