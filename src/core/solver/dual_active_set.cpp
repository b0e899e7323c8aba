#include "sinew/solver/dual_active_set.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxRounds = 20;

// Relative tolerances, in scaled units.
constexpr double kFeasibility = 1e-12;      // missing a limit, against the terms of the row
constexpr double kMostFeasibility = 1e-10;  // the same, once many iterations have passed
constexpr double kNoise = 1e-14;            // missing a limit, against the magnitude of x
constexpr double kDependent = 1e-10;        // share of a normal that the active ones do not span
constexpr double kDependentAtStart = 1e-7;  // the same for a guessed active set, which need not be taken
constexpr double kLeastScale = 1e-15;       // of points and of duals, where the problem names none
constexpr double kWrongSign = 1e-12;        // dual of the wrong sign, against the largest dual
constexpr double kBlocking = 1e-11;         // rate of a dual, against the largest rate
constexpr double kImbalance = 1e-10;        // sum of the normals of an infeasibility proof
constexpr double kGap = 1e-10;              // gap of an infeasibility proof, against the terms it is summed from

}  // namespace

DualActiveSet::DualActiveSet(int max_variables, int max_rows)
    : factor_(max_variables),
      side_(static_cast<std::size_t>(max_variables + max_rows), Side::kNone),
      ignored_(static_cast<std::size_t>(max_variables + max_rows), 0),
      active_(static_cast<std::size_t>(max_variables), 0),
      active_dual_(max_variables),
      x_(max_variables),
      dual_(max_variables + max_rows),
      values_(max_variables + max_rows),
      centre_(max_variables),
      direction_(max_variables),
      dual_direction_(max_variables),
      dual_residual_(max_variables),
      primal_residual_(max_variables),
      dx_(max_variables),
      du_(max_variables) {}

void DualActiveSet::forget() {
  start_variables_ = start_rows_ = -1;
}

void DualActiveSet::start(const ScaledQp& qp, double lift) {
  const bool warm = qp.variables == start_variables_ && qp.rows == start_rows_;
  qp_ = &qp;
  start_variables_ = qp.variables;
  start_rows_ = qp.rows;
  iterations_ = 0;
  feasibility_ = kFeasibility;
  factor_.reset(qp.G.topLeftCorner(qp.variables, qp.variables), lift);
  x_.head(qp.variables).setZero();
  std::fill_n(ignored_.begin(), qp.constraints(), 0);
  if (!warm) std::fill_n(side_.begin(), qp.constraints(), Side::kNone);
  activateGuess();
}

void DualActiveSet::activateGuess() {
  for (int k = 0; k < qp_->constraints(); ++k)
    if (isEquality(k)) activate(k, Side::kEquality, kDependent);
  for (int k = 0; k < qp_->constraints(); ++k) {
    if (isEquality(k)) continue;
    const Side guess = side(k);
    side(k) = Side::kNone;
    if (guess == Side::kLower && std::isfinite(qp_->lower(k))) activate(k, Side::kLower, kDependentAtStart);
    if (guess == Side::kUpper && std::isfinite(qp_->upper(k))) activate(k, Side::kUpper, kDependentAtStart);
  }
}

void DualActiveSet::activate(int constraint, Side at, double tolerance) {
  side(constraint) = Side::kNone;
  if (factor_.size() == factor_.variables()) return;
  project(constraint);
  if (!factor_.dependent(tolerance)) append(constraint, at, 0);
}

void DualActiveSet::project(int constraint) {
  if (constraint < qp_->variables)
    factor_.project(constraint);
  else
    factor_.project(qp_->normals.col(constraint - qp_->variables).head(qp_->variables));
}

void DualActiveSet::append(int constraint, Side at, double dual) {
  active(factor_.size()) = constraint;
  active_dual_(factor_.size()) = dual;
  side(constraint) = at;
  factor_.append();
}

void DualActiveSet::remove(int position) {
  side(active(position)) = Side::kNone;
  factor_.remove(position);
  for (int j = position; j < factor_.size(); ++j) {
    active(j) = active(j + 1);
    active_dual_(j) = active_dual_(j + 1);
  }
}

double DualActiveSet::calcValue(int constraint) const {
  const int n = qp_->variables;
  return constraint < n ? x_(constraint) : qp_->normals.col(constraint - n).head(n).dot(x_.head(n));
}

void DualActiveSet::addNormal(int constraint, double factor, VecX& sum) const {
  const int n = qp_->variables;
  if (constraint < n)
    sum(constraint) += factor;
  else
    sum.head(n) += factor * qp_->normals.col(constraint - n).head(n);
}

QpStatus DualActiveSet::minimise(const Eigen::Ref<const VecX>& centre, int max_iterations) {
  centre_.head(qp_->variables) = centre;
  settle();
  for (int round = 0; round < kMaxRounds; ++round) {
    for (Violation violation = findViolation(); violation.constraint >= 0; violation = findViolation()) {
      const QpStatus status = enforce(violation, max_iterations);
      if (status != QpStatus::kSolved) return status;
    }
    if (settle() && findViolation().constraint < 0) {
      scatterDuals();
      return QpStatus::kSolved;
    }
  }
  return QpStatus::kIterationLimit;
}

/// Returns whether nothing had to go.
bool DualActiveSet::settle() {
  refine();
  bool settled = true;
  for (int position = findWrongSign(); position >= 0; position = findWrongSign()) {
    remove(position);
    refine();
    ++iterations_;
    settled = false;
  }
  return settled;
}

void DualActiveSet::refine() {
  const int n = qp_->variables;
  const int active_count = factor_.size();
  auto r = dual_residual_.head(n);
  r.noalias() = qp_->G.topLeftCorner(n, n) * x_.head(n);
  r = -r - qp_->g.head(n) - factor_.proximal().cwiseProduct(x_.head(n) - centre_.head(n));
  for (int j = 0; j < active_count; ++j) {
    const int k = active(j);
    addNormal(k, active_dual_(j), dual_residual_);
    primal_residual_(j) = (side(k) == Side::kUpper ? qp_->upper(k) : qp_->lower(k)) - calcValue(k);
  }
  factor_.solve(r, primal_residual_.head(active_count), dx_.head(n), du_.head(active_count));
  x_.head(n) += dx_.head(n);
  active_dual_.head(active_count) += du_.head(active_count);
  magnitude_ = std::max({kLeastScale, calcLargest(x_.head(n)), calcLargest(qp_->g.head(n))});
}

int DualActiveSet::findWrongSign() const {
  const double scale =
      std::max({kLeastScale, calcLargest(active_dual_.head(factor_.size())), calcLargest(qp_->g.head(qp_->variables))});
  double worst = -kWrongSign * scale;
  int position = -1;
  for (int j = 0; j < factor_.size(); ++j) {
    const double dual = active_dual_(j) * calcSign(side(active(j)));
    if (side(active(j)) == Side::kEquality || dual >= worst) continue;
    worst = dual;
    position = j;
  }
  return position;
}

DualActiveSet::Violation DualActiveSet::findViolation() {
  const int n = qp_->variables;
  const int m = qp_->rows;
  values_.head(n) = x_.head(n);
  values_.segment(n, m).noalias() = qp_->normals.topLeftCorner(n, m).transpose() * x_.head(n);
  Violation worst;
  for (int k = 0; k < n + m; ++k) {
    const double below = qp_->lower(k) - values_(k);
    const double above = values_(k) - qp_->upper(k);
    const double amount = std::max(below, above);
    if (amount <= worst.amount || side(k) != Side::kNone || ignored_[static_cast<std::size_t>(k)]) continue;
    const double sign = below > above ? 1 : -1;
    if (amount > calcTolerance(k, sign)) worst = {k, sign, amount};
  }
  return worst;
}

double DualActiveSet::calcTolerance(int constraint, double sign) const {
  const int n = qp_->variables;
  const double terms = constraint < n ? std::abs(x_(constraint))
                                      : qp_->normals.col(constraint - n).head(n).cwiseAbs().dot(x_.head(n).cwiseAbs());
  return feasibility_ * (terms + std::abs(limit(constraint, sign))) + kNoise * magnitude_;
}

QpStatus DualActiveSet::enforce(Violation violation, int max_iterations) {
  const int k = violation.constraint;
  const double sign = violation.sign;
  auto z = direction_.head(qp_->variables);
  double dual = 0;
  for (;;) {
    if (iterations_ >= max_iterations) return QpStatus::kIterationLimit;
    ++iterations_;
    widenTolerance();
    auto r = dual_direction_.head(factor_.size());
    project(k);
    factor_.calcDualDirection(r);
    const bool dependent = factor_.dependent(kDependent);
    const Blocking blocking = findBlocking(sign);
    if (dependent && blocking.position < 0) return concludeDependent(violation);

    const double full = dependent ? kInfinity : violation.amount / factor_.curvature();
    const double step = sign * std::min(full, blocking.length);
    active_dual_.head(factor_.size()) -= step * r;
    dual += step;
    if (!dependent) {
      factor_.calcPrimalDirection(z);
      x_.head(qp_->variables) += step * z;
      magnitude_ = std::max(magnitude_, calcLargest(x_.head(qp_->variables)));
    }
    if (full <= blocking.length) {
      std::fill_n(ignored_.begin(), qp_->constraints(), 0);
      append(k, isEquality(k) ? Side::kEquality : (sign > 0 ? Side::kLower : Side::kUpper), dual);
      return QpStatus::kSolved;
    }
    remove(blocking.position);
    violation.amount = std::max(0.0, sign * (limit(k, sign) - calcValue(k)));
  }
}

/// The first active dual that reaches zero along the dual direction.
DualActiveSet::Blocking DualActiveSet::findBlocking(double sign) const {
  const auto r = dual_direction_.head(factor_.size());
  const double smallest = kBlocking * std::max(1.0, calcLargest(r));
  Blocking first{-1, kInfinity};
  for (int j = 0; j < factor_.size(); ++j) {
    const Side at = side(active(j));
    const double rate = sign * calcSign(at) * r(j);
    if (at == Side::kEquality || rate <= smallest) continue;
    const double length = std::max(0.0, calcSign(at) * active_dual_(j)) / rate;
    if (length < first.length) first = {j, length};
  }
  return first;
}

/// A violated limit that is a combination of the active ones with no dual to give way: a proof that nothing is
/// feasible, unless it is missed by rounding only.
QpStatus DualActiveSet::concludeDependent(const Violation& violation) {
  if (provesInfeasible(violation)) return QpStatus::kInfeasible;
  ignored_[static_cast<std::size_t>(violation.constraint)] = 1;
  settle();
  return QpStatus::kSolved;
}

bool DualActiveSet::provesInfeasible(const Violation& violation) {
  const int n = qp_->variables;
  const int k = violation.constraint;
  const int active_count = factor_.size();
  auto r = dual_direction_.head(active_count);

  // One step of refinement: the dual direction of what r leaves of the normal.
  calcRemainder(k);
  factor_.project(dx_.head(n));
  factor_.calcDualDirection(du_.head(active_count));
  r += du_.head(active_count);
  const double smallest = kBlocking * std::max(1.0, calcLargest(r));
  for (int j = 0; j < active_count; ++j) {
    const Side at = side(active(j));
    const bool wrong = at != Side::kEquality && violation.sign * calcSign(at) * r(j) > 0;
    if (wrong || std::abs(r(j)) <= smallest) r(j) = 0;
  }
  calcRemainder(k);

  active_dual_.head(active_count) = -violation.sign * r;
  scatterDuals();
  dual_(k) = violation.sign;
  double gap = 0;
  double terms = 0;
  for (int j = 0; j < qp_->constraints(); ++j) {
    if (dual_(j) == 0) continue;
    const double term = dual_(j) * limit(j, dual_(j));
    gap += term;
    terms += std::abs(term);
  }
  return gap > kGap * terms && calcLargest(dx_.head(n)) <= kImbalance * calcLargest(dual_.head(qp_->constraints()));
}

/// dx = normal - N r
void DualActiveSet::calcRemainder(int constraint) {
  dx_.head(qp_->variables).setZero();
  addNormal(constraint, 1, dx_);
  for (int j = 0; j < factor_.size(); ++j) addNormal(active(j), -dual_direction_(j), dx_);
}

void DualActiveSet::scatterDuals() {
  dual_.head(qp_->constraints()).setZero();
  for (int j = 0; j < factor_.size(); ++j) {
    const Side at = side(active(j));
    const bool wrong = at != Side::kEquality && active_dual_(j) * calcSign(at) < 0;
    dual_(active(j)) = wrong ? 0 : active_dual_(j);
  }
}

void DualActiveSet::widenTolerance() {
  const int few = 3 * qp_->constraints() + 30;
  if (iterations_ % few == 0) feasibility_ = std::min(10 * feasibility_, kMostFeasibility);
}

}  // namespace sinew
