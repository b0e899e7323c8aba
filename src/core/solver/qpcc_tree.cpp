#include "sinew/solver/qpcc_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kClosed = 1e-9;       // gaps and forces below are zero
constexpr double kPrune = 1e-7;        // relative gain not worth a node
constexpr double kNegligible = 1e-10;  // the same, against the objective at rest
constexpr double kUnexplained = 1e-6;  // relative difference between a bound and the point said to reach it
constexpr int kNodesPerDescent = 4;

}  // namespace

QpccTree::QpccTree(const QpccSizes& capacity)
    : relaxation_(capacity),
      nodes_(static_cast<std::size_t>(capacity.contacts + 1),
             DualQp(capacity.contacts + capacity.unknowns, capacity.contacts + capacity.rows)),
      open_(static_cast<std::size_t>(capacity.contacts + capacity.unknowns), 0) {}

QpccTree::Outcome QpccTree::explore(const ScaledQpcc& problem, SearchBudget& budget, TreeGuide& guide) {
  problem_ = &problem;
  budget_ = &budget;
  guide_ = &guide;
  doubtful_ = false;
  if (!budget.nodesLeft() || !relaxation_.prepare(problem, &budget) || !startRoot()) return Outcome::kInterrupted;
  slack_ = relaxation_.calcSlack();
  return explore(0) && !doubtful_ ? Outcome::kExhausted : Outcome::kInterrupted;
}

bool QpccTree::startRoot() {
  std::fill(open_.begin(), open_.end(), 0);
  for (int i = 0; i < problem_->size.contacts; ++i) open_[static_cast<std::size_t>(i)] = guide_->isOpen(i) ? 1 : 0;
  return relaxation_.start(nodes_[0], open_, budget_);
}

/// Of a node's QP, without the constant.
double QpccTree::cutoff() const {
  const double best = guide_->bestObjective();
  if (!std::isfinite(best)) return best;
  return best - kPrune * std::abs(best) - (1 + kNegligible) * relaxation_.constant() + slack_;
}

/// False if the budget ended.
bool QpccTree::explore(int depth) {
  if (!budget_->nodesLeft()) return false;
  budget_->countNode();
  const int count = budget_->nodes();
  DualQp& node = nodes_[static_cast<std::size_t>(depth)];
  const DualQp::Outcome outcome = node.minimise(relaxation_.rows(), relaxation_.limits(), cutoff(), budget_);
  if (outcome == DualQp::Outcome::kInterrupted) return false;
  if (outcome == DualQp::Outcome::kFailed) doubtful_ = true;
  if (outcome != DualQp::Outcome::kOptimal) return true;

  const auto x = node.x().tail(problem_->size.unknowns);
  const int branch = findBranch(node);
  if (depth == 0 && branch >= 0 && node.value() <= cutoff()) guide_->widen();
  if (branch < 0 || count % kNodesPerDescent == 1) {
    guide_->descendFrom(x);
    if (branch >= 0) guide_->restart();
  }
  const bool cut = node.value() > cutoff();
  if (branch < 0) {
    // The relaxed point is one of the QPCC: the descent must have found its value.
    const double gain = guide_->bestObjective() - (node.value() + relaxation_.constant());
    const double tolerance = kUnexplained * std::abs(guide_->bestObjective()) + 1e-9 * relaxation_.constant();
    if (!cut && !(std::isfinite(gain) && gain <= tolerance)) doubtful_ = true;
    return true;
  }
  if (cut) return true;
  const bool pressing = guide_->presses(x, branch);
  return exploreChild(depth, branch, pressing) && exploreChild(depth, branch, !pressing);
}

bool QpccTree::exploreChild(int depth, int contact, bool pressing) {
  nodes_[static_cast<std::size_t>(depth) + 1].copy(nodes_[static_cast<std::size_t>(depth)]);
  const int force = problem_->limitedRows() + contact;
  double& closed = relaxation_.limits().upper(pressing ? contact : force);
  closed = 0;
  const bool done = explore(depth + 1);
  closed = std::numeric_limits<double>::infinity();
  return done;
}

bool QpccTree::isDecided(int contact) {
  const VecX& upper = relaxation_.limits().upper;
  return upper(contact) == 0 || upper(problem_->limitedRows() + contact) == 0;
}

/// -1 if the point is complementary.
int QpccTree::findBranch(const DualQp& node) {
  int branch = -1;
  double largest = 0;
  for (int i = 0; i < problem_->size.contacts; ++i) {
    const double z = node.x()(i);
    const double g = node.rowValues()(i);
    if (isDecided(i) || z < kClosed || g < kClosed || z * g <= largest) continue;
    largest = z * g;
    branch = i;
  }
  return branch;
}

}  // namespace sinew
