#include "sinew/inverse/contact_search.h"

#include <algorithm>
#include <limits>

namespace sinew {
namespace {

// Weights of the energy and of the change of effort, relative to the best-driven direction: they choose among pieces
// that reach the target alike.
constexpr double kEnergy = 1e-6;
constexpr double kRegularisation = 1e-8;

QpccSizes makeSizes(const RobotModel& robot, int max_effector_rows) {
  return {robot.actuatorCount(), robot.actuatorCount(), max_effector_rows, std::max(1, robot.maxContacts())};
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
  const int e = static_cast<int>(goal.rows.size());
  QpccProblem& p = problem_;
  p.resize({n, n, e, c});
  for (int k = 0; k < e; ++k) {
    p.E_a.row(k).head(n) = W.row(goal.rows[k]).head(n);
    p.E_c.row(k).head(c) = W.row(goal.rows[k]).segment(first, c);
  }
  p.e.head(e) = goal.error.head(e);
  double best = 0;
  for (int i = 0; i < n; ++i) best = std::max(best, p.E_a.col(i).head(e).squaredNorm() / W(i, i));
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
  p.C_a.topLeftCorner(c, n) = W.block(first, 0, c, n);
  p.C_c.topLeftCorner(c, c) = W.block(first, first, c, c);
  p.c.head(c) = robot.gap() + robot.freeMotion().segment(first, c);
}

void ContactSearch::recall(const ContactList& contacts) {
  guess_.valid = known_;
  guess_.x.setZero();
  guess_.margin = 0;
  guess_.reach.setConstant(std::numeric_limits<double>::infinity());
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

QpccStatus ContactSearch::solve(const CondensedRobot& robot, const ContactList& contacts, const EffectorGoal& goal,
                                const CycleLimits& limits, const VecX& effort, double damping) {
  gather(robot, goal, limits, effort, damping);
  recall(contacts);
  const ControlDescription& control = robot_.description().control;
  QpccBudget budget;
  budget.max_pieces = control.max_pieces;
  budget.max_nodes = control.max_nodes;
  const QpccStatus status = solver_.solve(problem_, guess_, budget, solution_);
  if (status == QpccStatus::kSolved || status == QpccStatus::kGivenWay) remember(contacts);
  return status;
}

}  // namespace sinew
