#include "sinew/solver/dual_qp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFeasibility = 1e-9;  // missing a limit
constexpr double kRounding = 1e-13;    // the same, against the terms of the row
constexpr double kDependent = 1e-16;   // squared share of a normal that the active ones do not span
constexpr double kBlocking = 1e-12;    // rate of a dual
constexpr double kFlatPivot = 1e-14;   // pivot of G, against its diagonal

}  // namespace

DualQp::DualQp(int max_unknowns, int max_rows, InstructionSet set)
    : kernels_(&denseKernelsOf(set)),
      J_(max_unknowns, max_unknowns),
      R_(max_unknowns, max_unknowns),
      x_(max_unknowns),
      dual_(max_unknowns),
      sign_(max_unknowns),
      limit_(static_cast<std::size_t>(max_unknowns), 0),
      fixed_(static_cast<std::size_t>(max_unknowns), 0),
      order_(static_cast<std::size_t>(max_unknowns), 0),
      values_(max_rows + max_unknowns),
      misses_(max_rows + max_unknowns),
      projected_(max_unknowns),
      direction_(max_unknowns),
      dual_direction_(max_unknowns) {}

bool DualQp::start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, QpInterruption* interruption) {
  return start(G, g, 0, {}, interruption);
}

bool DualQp::start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, int rows,
                   const std::vector<char>& held, QpInterruption* interruption) {
  const int n = unknowns_ = static_cast<int>(g.size());
  rows_ = count_ = steps_ = 0;
  const auto isHeld = [&held](int i) { return !held.empty() && held[static_cast<std::size_t>(i)] != 0; };
  int first = 0, next = 0;
  for (int i = 0; i < n; ++i) first += isHeld(i) ? 1 : 0;
  for (int i = 0, last = first; i < n; ++i) order_[static_cast<std::size_t>(isHeld(i) ? next++ : last++)] = i;
  if (!factorise(G, interruption)) return false;
  invert(first);
  for (int k = 0; k < first; ++k) {
    limit_[static_cast<std::size_t>(k)] = rows + order_[static_cast<std::size_t>(k)];
    fixed_[static_cast<std::size_t>(k)] = 0;
  }
  sign_.head(first).setOnes();
  count_ = first;
  release(g);

  x_.head(n).setZero();
  for (int k = count_; k < n; ++k) x_.head(n) -= projected_(k) * J_.col(k).head(n);
  value_ = -0.5 * projected_.segment(count_, n - count_).squaredNorm();
  return true;
}

/// G = U U^T in the chosen order, U upper triangular and in R_ for now.
bool DualQp::factorise(const Eigen::Ref<const MatX>& G, QpInterruption* interruption) {
  for (int j = unknowns_ - 1; j >= 0; --j) {
    if (interruption && interruption->due()) return false;
    const int own = order_[static_cast<std::size_t>(j)];
    double pivot = G(own, own);
    auto u = R_.col(j).head(j);
    for (int i = 0; i < j; ++i) u(i) = G(order_[static_cast<std::size_t>(i)], own);
    const int later = unknowns_ - 1 - j;
    auto row = direction_.head(later);
    row = -R_.row(j).segment(j + 1, later).transpose();
    pivot -= row.squaredNorm();
    if (later > 0) kernels_->addColumns(&R_(0, j + 1), stride(), j, row.data(), later, u.data());
    if (!(pivot > kFlatPivot * G(own, own))) return false;
    R_(j, j) = std::sqrt(pivot);
    u /= R_(j, j);
  }
  return true;
}

/// J = U^-T: row i of a lower triangle ends at column i, so that the leading columns span the leading unknowns, as they
/// have to the active normals. The R of `held` of these is the head of U^-1.
void DualQp::invert(int held) {
  const int n = unknowns_;
  for (int j = n - 1; j >= 0; --j) {
    auto column = direction_.head(j + 1);
    column.setZero();
    column(j) = 1;
    for (int k = j; k >= 0; --k) {
      column(k) /= R_(k, k);
      column.head(k) -= column(k) * R_.col(k).head(k);
    }
    auto row = J_.row(order_[static_cast<std::size_t>(j)]);
    row.head(j + 1) = column.transpose();
    row.segment(j + 1, n - j - 1).setZero();
    if (j < held) R_.col(j).head(j + 1) = column;
  }
}

/// Lets go of active limits until no dual is negative, the most negative first; leaves J^T g in projected_.
void DualQp::release(const Eigen::Ref<const VecX>& g) {
  for (;;) {
    kernels_->multiplyColumns(J_.data(), stride(), unknowns_, g.data(), unknowns_, projected_.data());
    auto u = dual_.head(count_);
    u = projected_.head(count_);
    for (int k = count_ - 1; k >= 0; --k) {
      u(k) /= R_(k, k);
      u.head(k) -= u(k) * R_.col(k).head(k);
    }
    int worst = 0;
    if (count_ == 0 || u.minCoeff(&worst) >= 0) return;
    remove(worst);
  }
}

void DualQp::copy(const DualQp& other) {
  const int n = unknowns_ = other.unknowns_;
  rows_ = other.rows_;
  count_ = other.count_;
  steps_ = other.steps_;
  value_ = other.value_;
  J_.topLeftCorner(n, n) = other.J_.topLeftCorner(n, n);
  for (int j = 0; j < count_; ++j) R_.col(j).head(j + 1) = other.R_.col(j).head(j + 1);
  x_.head(n) = other.x_.head(n);
  dual_.head(count_) = other.dual_.head(count_);
  sign_.head(count_) = other.sign_.head(count_);
  std::copy_n(other.limit_.begin(), count_, limit_.begin());
  std::copy_n(other.fixed_.begin(), count_, fixed_.begin());
}

DualQp::Outcome DualQp::minimise(const QpRows& rows, const QpLimits& limits, double cutoff,
                                 QpInterruption* interruption) {
  rows_ = static_cast<int>(rows.constant.size());
  steps_ = 0;
  for (;;) {
    if (interruption && interruption->due()) return Outcome::kInterrupted;
    updateValues(rows);
    const Violation violation = findViolation(rows, limits);
    if (violation.limit < 0) return std::isfinite(value_) ? Outcome::kOptimal : Outcome::kFailed;
    const Outcome outcome = enforce(rows, limits, violation, cutoff);
    if (outcome != Outcome::kOptimal) return outcome;
  }
}

void DualQp::updateValues(const QpRows& rows) {
  auto y = values_.head(rows_);
  y = rows.constant;
  kernels_->addColumns(rows.matrix.data(), static_cast<int>(rows.matrix.outerStride()), rows_, x_.data(), unknowns_,
                       values_.data());
  values_.segment(rows_, unknowns_) = x_.head(unknowns_);
}

/// The worst miss of an inactive limit that is more than rounding.
DualQp::Violation DualQp::findViolation(const QpRows& rows, const QpLimits& limits) {
  const int all = rows_ + unknowns_;
  const auto values = values_.head(all);
  auto misses = misses_.head(all);
  misses = (limits.lower.head(all) - values).cwiseMax(values - limits.upper.head(all));
  // An active limit can only be missed on its other side, where limits cross.
  for (int k = 0; k < count_; ++k) {
    const int limit = activeLimit(k);
    misses(limit) = activeAtLower(k) ? values(limit) - limits.upper(limit) : limits.lower(limit) - values(limit);
  }
  while (all > 0) {
    int k = 0;
    const double amount = misses.maxCoeff(&k);
    if (!(amount > kFeasibility)) return {};
    const bool below = limits.lower(k) - values(k) > values(k) - limits.upper(k);
    if (amount > calcTolerance(rows, k)) return {k, below ? 1.0 : -1.0, amount};
    misses(k) = 0;
  }
  return {};
}

double DualQp::calcTolerance(const QpRows& rows, int limit) const {
  const double terms = limit < rows_ ? rows.matrix.row(limit).cwiseAbs().dot(x_.head(unknowns_).cwiseAbs()) +
                                           std::abs(rows.constant(limit))
                                     : std::abs(x_(limit - rows_));
  return kFeasibility + kRounding * terms;
}

void DualQp::project(const QpRows& rows, const Violation& violation) {
  const int n = unknowns_;
  auto d = projected_.head(n);
  if (violation.limit >= rows_) {
    d = violation.sign * J_.row(violation.limit - rows_).head(n).transpose();
    return;
  }
  auto normal = direction_.head(n);
  normal = violation.sign * rows.matrix.row(violation.limit).transpose();
  kernels_->multiplyColumns(J_.data(), stride(), n, normal.data(), n, d.data());
}

void DualQp::calcDirections() {
  const int n = unknowns_;
  const auto d = projected_.head(n);
  auto z = direction_.head(n);
  z.setZero();
  if (count_ < n) kernels_->addColumns(&J_(0, count_), stride(), n, &d(count_), n - count_, z.data());
  free_curvature_ = d.tail(n - count_).squaredNorm();
  auto r = dual_direction_.head(count_);
  r = d.head(count_);
  for (int k = count_ - 1; k >= 0; --k) {
    r(k) /= R_(k, k);
    r.head(k) -= r(k) * R_.col(k).head(k);
  }
}

/// Position of the first active dual to reach zero, -1 if none does.
int DualQp::findBlocking(double& length) const {
  int first = -1;
  length = kInfinity;
  for (int k = 0; k < count_; ++k) {
    if (fixed_[static_cast<std::size_t>(k)] || dual_direction_(k) <= kBlocking) continue;
    const double until = std::max(0.0, dual_(k)) / dual_direction_(k);
    if (until >= length) continue;
    length = until;
    first = k;
  }
  return first;
}

DualQp::Outcome DualQp::enforce(const QpRows& rows, const QpLimits& limits, Violation violation, double cutoff) {
  const int max_steps = 60 + 20 * unknowns_ + rows_;
  double dual = 0;
  project(rows, violation);
  for (;;) {
    if (++steps_ > max_steps) return Outcome::kFailed;
    calcDirections();
    double blocked = 0;
    const int blocking = findBlocking(blocked);
    const bool dependent = !(free_curvature_ > kDependent * projected_.head(unknowns_).squaredNorm());
    const double full = dependent ? kInfinity : violation.amount / free_curvature_;
    const double step = std::min(full, blocked);
    if (step == kInfinity) return Outcome::kInfeasible;

    dual_.head(count_) -= step * dual_direction_.head(count_);
    if (!dependent) {
      x_.head(unknowns_) += step * direction_.head(unknowns_);
      value_ += step * free_curvature_ * (0.5 * step + dual);
      violation.amount -= step * free_curvature_;
    }
    dual += step;
    const bool fixed = limits.lower(violation.limit) == limits.upper(violation.limit);
    if (full <= blocked) append(violation.limit, violation.sign, dual, fixed);
    if (value_ > cutoff) return Outcome::kCutOff;
    if (full <= blocked) return Outcome::kOptimal;
    remove(blocking);
    project(rows, violation);
  }
}

/// A Householder reflection brings J2^T n onto its first entry; J2 times its vector is the primal direction but for one
/// column.
void DualQp::append(int limit, double sign, double dual, bool fixed) {
  const int n = unknowns_;
  const int q = count_;
  auto d = projected_.segment(q, n - q);
  const double length = std::sqrt(free_curvature_);
  const double pivot = d(0) > 0 ? -length : length;
  auto w = direction_.head(n);
  w -= pivot * J_.col(q).head(n);
  const double factor = 1 / (free_curvature_ - pivot * d(0));
  R_.col(q).head(q) = projected_.head(q);
  R_(q, q) = pivot;
  d(0) -= pivot;
  w *= factor;
  kernels_->subtractOuter(&J_(0, q), stride(), n, w.data(), d.data(), n - q);
  limit_[static_cast<std::size_t>(q)] = limit;
  fixed_[static_cast<std::size_t>(q)] = fixed ? 1 : 0;
  sign_(q) = sign;
  dual_(q) = dual;
  ++count_;
}

void DualQp::remove(int position) {
  for (int k = position + 1; k < count_; ++k) {
    R_.col(k - 1).head(k + 1) = R_.col(k).head(k + 1);
    dual_(k - 1) = dual_(k);
    sign_(k - 1) = sign_(k);
    limit_[static_cast<std::size_t>(k - 1)] = limit_[static_cast<std::size_t>(k)];
    fixed_[static_cast<std::size_t>(k - 1)] = fixed_[static_cast<std::size_t>(k)];
  }
  --count_;
  // Rotations bring the columns that moved back to upper triangular form.
  const int n = unknowns_;
  for (int k = position; k < count_; ++k) {
    const double length = std::sqrt(R_(k, k) * R_(k, k) + R_(k + 1, k) * R_(k + 1, k));
    const double c = R_(k, k) / length;
    const double s = R_(k + 1, k) / length;
    for (int j = k; j < count_; ++j) {
      const double above = R_(k, j);
      R_(k, j) = c * above + s * R_(k + 1, j);
      R_(k + 1, j) = c * R_(k + 1, j) - s * above;
    }
    kernels_->rotate(&J_(0, k), &J_(0, k + 1), n, c, s);
  }
}

void DualQp::settle(const QpRows& rows, const QpLimits& limits) {
  updateValues(rows);
  // N^T dx = what is missing, with dx = J1 R^-T (...).
  auto t = dual_direction_.head(count_);
  for (int k = 0; k < count_; ++k) {
    const int limit = activeLimit(k);
    const double at = activeAtLower(k) ? limits.lower(limit) : limits.upper(limit);
    t(k) = (sign_(k) * (at - values_(limit)) - R_.col(k).head(k).dot(t.head(k))) / R_(k, k);
  }
  for (int k = 0; k < count_; ++k) x_.head(unknowns_) += t(k) * J_.col(k).head(unknowns_);
  updateValues(rows);
}

}  // namespace sinew
