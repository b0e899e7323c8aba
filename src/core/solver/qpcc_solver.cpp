#include "sinew/solver/qpcc_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kLog2VisitedSets = 16;
constexpr double kMostDrift = 1e-10;  // of the tableau, before it is rebuilt
constexpr double kNearby = 0.3;       // share of the box in which restarts around the best point fall
constexpr double kBeyond = 4;         // soft ranges by which restarts go beyond limits that give way

bool limitsAreValid(const Eigen::Ref<const VecX>& lower, const Eigen::Ref<const VecX>& upper) {
  return (lower.array() < kInfinity).all() && (upper.array() > -kInfinity).all();
}

/// Zero times anything else is no zero; a sum of them is fast.
template <typename Entries>
bool areFinite(const Entries& entries) {
  return (0.0 * entries).sum() == 0;
}

bool isFinite(const QpccProblem& p) {
  const int na = p.size.unknowns;
  const int nr = p.size.rows;
  const int ne = p.size.effectors;
  const int nc = p.size.contacts;
  return areFinite(p.E_a.topLeftCorner(ne, na)) && areFinite(p.E_c.topLeftCorner(ne, nc)) && areFinite(p.e.head(ne)) &&
         areFinite(p.Q.topLeftCorner(na, na)) && areFinite(p.q.head(na)) && areFinite(p.A_a.topLeftCorner(nr, na)) &&
         areFinite(p.A_c.topLeftCorner(nr, nc)) && areFinite(p.a.head(nr)) && areFinite(p.C_a.topLeftCorner(nc, na)) &&
         areFinite(p.C_c.topLeftCorner(nc, nc)) && areFinite(p.c.head(nc)) &&
         limitsAreValid(p.x_lower.head(na), p.x_upper.head(na)) &&
         limitsAreValid(p.soft_lower.head(na), p.soft_upper.head(na)) &&
         limitsAreValid(p.row_lower.head(nr), p.row_upper.head(nr));
}

void clear(QpccSolution& solution) {
  solution.status = QpccStatus::kFailed;
  solution.x.setZero();
  solution.z.setZero();
  solution.g.setZero();
  std::fill(solution.active.begin(), solution.active.end(), 0);
  solution.objective = kInfinity;
  solution.soft_violation.setZero();
  solution.row_violation = 0;
  solution.proved_global = false;
  solution.decomposition_objective = kInfinity;
  solution.declined_better = false;
  solution.declined_objective = kInfinity;
  solution.pieces = solution.nodes = 0;
  solution.deadline_ended = false;
}

double missOf(double value, double lower, double upper) {
  return std::max({lower - value, value - upper, 0.0});
}

}  // namespace

/// Lets the tree use the descents of the solver.
class QpccSolver::Guide : public TreeGuide {
 public:
  explicit Guide(QpccSolver& solver) : solver_(solver) {}

  double bestObjective() const override {
    return solver_.feasible() ? solver_.best_.answer.merit.objective : kInfinity;
  }
  void descendFrom(const Eigen::Ref<const VecX>& x) override { solver_.descendFrom(x); }
  bool isOpen(int contact) const override {
    return solver_.feasible() && solver_.best_.active[static_cast<std::size_t>(contact)] == 0;
  }
  void widen() override { solver_.widen(); }
  void restart() override { solver_.restart(); }
  bool presses(const Eigen::Ref<const VecX>& x, int contact) override {
    solveContactLcp(x, solver_.tableau_);
    return solver_.tableau_.isActive(contact);
  }

 private:
  QpccSolver& solver_;
};

QpccSolver::QpccSolver(const QpccSizes& capacity)
    : scaled_(capacity),
      tableau_(capacity),
      piece_(capacity),
      decomposition_(capacity),
      visited_(kLog2VisitedSets),
      tree_(capacity),
      found_(capacity),
      local_(capacity),
      reachable_(capacity),
      best_(capacity),
      polished_(capacity),
      map_(capacity.contacts + capacity.rows + capacity.effectors, capacity.unknowns + 1),
      start_(capacity.unknowns),
      held_start_(capacity.unknowns),
      guess_(capacity.unknowns),
      guess_row_(capacity.rows),
      reach_(capacity.rows),
      wanted_(static_cast<std::size_t>(capacity.contacts), 0) {
  held_.reserve(static_cast<std::size_t>(capacity.unknowns));
}

QpccStatus QpccSolver::solve(const QpccProblem& problem, const QpccGuess& guess, const QpccBudget& budget,
                             QpccSolution& solution) {
  clear(solution);
  if (!isFinite(problem)) return solution.status = QpccStatus::kNotFinite;
  scaled_.update(problem);
  tableau_.reset(scaled_);
  piece_.attach(scaled_);
  if (visits_) visits_->clear();
  search(guess, budget, solution);
  if (visits_) reportVisits();
  if (best_.answer.valid) conclude(problem, guess, solution);
  solution.pieces = budget_.pieces();
  solution.nodes = budget_.nodes();
  solution.deadline_ended = budget_.deadlinePassed();
  return solution.status;
}

void QpccSolver::watch(std::vector<QpccVisit>* visits) {
  visits_ = visits;
  decomposition_.watch(visits);
}

void QpccSolver::reportVisits() {
  const int n = scaled_.size.unknowns;
  for (QpccVisit& visit : *visits_) {
    visit.objective *= scaled_.objectiveUnit();
    visit.x.head(n) = scaled_.magnitude * scaled_.unknown_unit.head(n).cwiseProduct(visit.x.head(n));
  }
}

void QpccSolver::search(const QpccGuess& guess, const QpccBudget& budget, QpccSolution& solution) {
  budget_.start(budget);
  visited_.clear();
  local_.answer.valid = reachable_.answer.valid = best_.answer.valid = false;
  has_guess_ = guess.valid;
  restarts_ = 0;
  pairEqualities(tableau_, held_);
  if (guess.valid) startAtGuess(guess);
  local_ = best_;
  if (!local_.answer.valid || (budget.restarts > 0 && budget_.piecesLeft())) startAtRest();
  if (!local_.answer.valid) local_ = best_;
  if (local_.answer.valid && local_.answer.merit.feasible())
    solution.decomposition_objective = local_.answer.merit.objective * scaled_.objectiveUnit();

  restarts_left_ = budget.restarts - 1;
  if (!feasible()) widen();
  for (int k = 0; k < budget.elastic_restarts && !feasible() && budget_.piecesLeft(); ++k) restart();
  solution.proved_global = budget.max_nodes > 0 && exploreTree() && feasible();
  if (!solution.proved_global) widen();
  if (!local_.answer.valid) local_ = best_;
}

bool QpccSolver::exploreTree() {
  Guide guide(*this);
  return tree_.explore(scaled_, budget_, guide) == QpccTree::Outcome::kExhausted;
}

/// The guess's own piece first, then the contacts of its actuation.
void QpccSolver::startAtGuess(const QpccGuess& guess) {
  const int n = scaled_.size.unknowns;
  for (int k = 0; k < scaled_.size.contacts; ++k)
    wanted_[static_cast<std::size_t>(k)] = guess.active[static_cast<std::size_t>(scaled_.at(k))];
  guess_.head(n) = guess.x.head(n).cwiseQuotient(scaled_.magnitude * scaled_.unknown_unit.head(n));
  const int nr = scaled_.size.rows - scaled_.rigidRows();
  const auto row_unit = scaled_.row_scale.head(nr) / scaled_.magnitude;
  guess_row_.head(nr) = guess.row.head(nr).cwiseProduct(row_unit);
  reach_.head(nr) = guess.reach.head(nr).cwiseProduct(row_unit);
  tableau_.moveTo(wanted_);
  start_.head(n) = guess_.head(n).cwiseMax(scaled_.x_lower.head(n)).cwiseMin(scaled_.x_upper.head(n));
  descendFrom(start_.head(n));
}

void QpccSolver::startAtRest() {
  const int n = scaled_.size.unknowns;
  start_.head(n).setZero();
  start_.head(n) = start_.head(n).cwiseMax(scaled_.x_lower.head(n)).cwiseMin(scaled_.x_upper.head(n));
  descendFrom(start_.head(n));
}

/// The restarts that are left, where there is still something to look for.
void QpccSolver::widen() {
  for (; restarts_left_ > 0 && budget_.piecesLeft(); --restarts_left_) restart();
}

/// In turn: anywhere in the box, mostly at its corners, around the best point.
void QpccSolver::restart() {
  const int n = scaled_.size.unknowns;
  const int kind = restarts_++ % 3;
  for (int j = 0; j < n; ++j) {
    double lower = std::max(scaled_.x_lower(j), scaled_.soft_lower(j));
    double upper = std::min(scaled_.x_upper(j), scaled_.soft_upper(j));
    const double best = best_.answer.valid ? best_.answer.x(j) : 0;
    const double span = 1 + 2 * std::abs(best);
    if (!feasible()) {  // the limits that give way are left behind
      lower = std::max(scaled_.x_lower(j), lower - kBeyond * scaled_.soft_range(j));
      upper = std::min(scaled_.x_upper(j), upper + kBeyond * scaled_.soft_range(j));
    }
    if (!std::isfinite(lower)) lower = std::isfinite(upper) ? std::min(upper, best) - span : best - span;
    if (!std::isfinite(upper)) upper = std::max(lower, best) + span;
    double share = drawUnit();
    if (kind == 1) share = share < 0.5 ? 0 : (share < 0.9 ? 1 : drawUnit());
    start_(j) = lower + share * (upper - lower);
    if (kind == 2) start_(j) = best + kNearby * (upper - lower) * (share + drawUnit() - 1);
    start_(j) = std::min(std::max(start_(j), lower), upper);
  }
  descendFrom(start_.head(n));
}

/// SplitMix64, in [0, 1).
double QpccSolver::drawUnit() {
  random_ += 0x9e3779b97f4a7c15u;
  std::uint64_t bits = (random_ ^ (random_ >> 30)) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((bits ^ (bits >> 31)) >> 11) * 0x1p-53;
}

/// From the contacts of x, with the equalities held where that takes no x beyond its hard limits: the piece is then
/// sure to hold a point within them.
void QpccSolver::descendFrom(const Eigen::Ref<const VecX>& x) {
  const int n = scaled_.size.unknowns;
  if (tableau_.calcDrift() > kMostDrift) tableau_.rebuild();
  auto start = held_start_.head(n);
  start = x;
  const bool held = !held_.empty() && solveContactMcp(held_, start, tableau_) &&
                    (start.array() >= scaled_.x_lower.head(n).array()).all() &&
                    (start.array() <= scaled_.x_upper.head(n).array()).all();
  if (!held_.empty()) tableau_.rebuild();
  if (!held && !solveContactLcp(x, tableau_)) tableau_.rebuild();
  descend();
}

void QpccSolver::descend() {
  if (best_.answer.valid && budget_.due()) return;
  if (decomposition_.descend(!feasible(), tableau_, piece_, visited_, budget_, found_)) keep(found_);
}

void QpccSolver::keep(const QpccPoint& point) {
  const auto improves = [&point](const QpccPoint& other) {
    return !other.answer.valid || isBetter(point.answer.merit, other.answer.merit);
  };
  if (improves(best_)) best_ = point;
  if (has_guess_ && withinReach(point.answer) && improves(reachable_)) reachable_ = point;
}

bool QpccSolver::withinReach(const PieceAnswer& answer) const {
  for (int r = 0; r < scaled_.size.rows - scaled_.rigidRows(); ++r)
    if (std::abs(answer.row(r) - guess_row_(r)) > reach_(r)) return false;
  return true;
}

/// With the offset the objective is 1/2 |r|^2, r the effectors' errors and the root of Q times the unknowns, and the
/// order of two points turns first when r moves along their difference: the local point stays the worse one under every
/// change of r by the margin if it is worse by margin |r| |difference|.
double QpccSolver::calcHandicap(const QpccGuess& guess) const {
  const int n = scaled_.size.unknowns;
  const PieceAnswer& a = local_.answer;
  const PieceAnswer& b = reachable_.answer;
  double squared = (a.row - b.row).segment(scaled_.size.rows, scaled_.size.effectors).squaredNorm();
  for (int j = 0; j < n; ++j) squared += (a.x(j) - b.x(j)) * scaled_.Q.col(j).head(n).dot((a.x - b.x).head(n));
  const double total = 2 * (a.merit.objective + guess.offset / scaled_.objectiveUnit());
  return guess.margin * std::sqrt(std::max(0.0, total) * std::max(0.0, squared));
}

/// The best point, or with a guess the best of the local one and those within reach that beat it by the margin.
const QpccPoint& QpccSolver::choose(const QpccGuess& guess, QpccSolution& solution) const {
  if (!has_guess_) return best_;
  const QpccPoint* chosen = &local_;
  if (reachable_.answer.valid && isBetter(reachable_.answer.merit, local_.answer.merit)) {
    PieceMerit handicapped = reachable_.answer.merit;
    handicapped.objective += calcHandicap(guess);
    if (isBetter(handicapped, local_.answer.merit)) chosen = &reachable_;
  }
  if (isBetter(best_.answer.merit, chosen->answer.merit)) {
    solution.declined_better = true;
    solution.declined_objective = best_.answer.merit.objective * scaled_.objectiveUnit();
    solution.proved_global = false;
  }
  return *chosen;
}

/// Reports the polished chosen point; and the local one instead should polishing turn the order of the two.
void QpccSolver::conclude(const QpccProblem& problem, const QpccGuess& guess, QpccSolution& solution) {
  const QpccPoint& chosen = choose(guess, solution);
  const bool moved = chosen.active != local_.active;
  if (moved) {
    polish(chosen);
    report(problem, solution);
    if (!local_.answer.merit.feasible() || budget_.due()) return;
    const double objective = solution.objective;
    polish(local_);
    solution.decomposition_objective = polished_.merit.objective * scaled_.objectiveUnit();
    if (objective <= solution.decomposition_objective || solution.status != QpccStatus::kSolved) return;
  } else {
    polish(chosen);
  }
  report(problem, solution);
  if (solution.status == QpccStatus::kSolved) solution.decomposition_objective = solution.objective;
}

/// Solves the piece of a point without the regularisations of the search, where the piece allows.
void QpccSolver::polish(const QpccPoint& point) {
  const int n = scaled_.size.unknowns;
  tableau_.rebuild(point.active);
  auto map = map_.topLeftCorner(scaled_.tableRows(), n + 1);
  const PieceMerit& merit = point.answer.merit;
  if (tableau_.refine(map) && piece_.polish(map, merit, polished_)) return;
  map = tableau_.map();
  if (!piece_.polish(map, merit, polished_)) polished_ = point.answer;
}

/// The polished point in SI units.
void QpccSolver::report(const QpccProblem& p, QpccSolution& solution) const {
  const PieceAnswer& answer = polished_;
  const int na = p.size.unknowns;
  const int nc = p.size.contacts;
  const int nr = p.size.rows;
  const int ne = p.size.effectors;
  auto x = solution.x.head(na);
  auto z = solution.z.head(nc);
  auto g = solution.g.head(nc);
  x = scaled_.magnitude * scaled_.unknown_unit.head(na).cwiseProduct(answer.x.head(na));
  x = x.cwiseMax(p.x_lower.head(na)).cwiseMin(p.x_upper.head(na));
  z.setZero();
  g.setZero();
  for (int k = 0; k < scaled_.size.contacts; ++k) {
    const int i = scaled_.at(k);
    solution.active[static_cast<std::size_t>(i)] = tableau_.isActive(k) ? 1 : 0;
    if (!tableau_.isActive(k)) continue;
    const double force = map_.row(k).head(na).dot(answer.x.head(na)) + map_(k, na);
    z(i) = std::max(0.0, scaled_.magnitude * scaled_.contact_unit(k) * force);
  }
  for (int i = 0; i < nc; ++i) {
    if (solution.active[static_cast<std::size_t>(i)]) continue;
    g(i) = p.C_a.row(i).head(na).dot(x) + p.C_c.row(i).head(nc).dot(z) + p.c(i);
    if (p.C_c(i, i) > 0) g(i) = std::max(0.0, g(i));
  }

  double sum = 0;
  for (int r = 0; r < ne; ++r) {
    const double error = p.E_a.row(r).head(na).dot(x) + p.E_c.row(r).head(nc).dot(z) + p.e(r);
    sum += error * error;
  }
  for (int j = 0; j < na; ++j) sum += x(j) * (p.Q.col(j).head(na).dot(x) + 2 * p.q(j));
  solution.objective = 0.5 * sum;
  const PieceMerit& merit = answer.merit;
  for (int j = 0; j < na && merit.soft_violation > 0; ++j)
    solution.soft_violation(j) = missOf(x(j), p.soft_lower(j), p.soft_upper(j));
  for (int r = 0; r < nr && merit.row_violation > 0; ++r) {
    const double value = p.A_a.row(r).head(na).dot(x) + p.A_c.row(r).head(nc).dot(z) + p.a(r);
    solution.row_violation = std::max(solution.row_violation, missOf(value, p.row_lower(r), p.row_upper(r)));
  }
  solution.status = merit.row_violation > 0    ? QpccStatus::kInfeasible
                    : merit.soft_violation > 0 ? QpccStatus::kGivenWay
                                               : QpccStatus::kSolved;
}

}  // namespace sinew
