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

DualQp::DualQp(int max_unknowns, int max_rows)
    : J_(max_unknowns, max_unknowns),
      R_(max_unknowns, max_unknowns),
      x_(max_unknowns),
      dual_(max_unknowns),
      sign_(max_unknowns),
      limit_(static_cast<std::size_t>(max_unknowns), 0),
      fixed_(static_cast<std::size_t>(max_unknowns), 0),
      values_(max_rows + max_unknowns),
      misses_(max_rows + max_unknowns),
      projected_(max_unknowns),
      direction_(max_unknowns),
      dual_direction_(max_unknowns) {}

bool DualQp::start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, QpInterruption* interruption) {
  const int n = unknowns_ = static_cast<int>(g.size());
  rows_ = count_ = steps_ = 0;
  // G = U^T U with U in R_ for now, column by column; J = U^-1.
  for (int j = 0; j < n; ++j) {
    if (interruption && interruption->due()) return false;
    auto u = R_.col(j).head(j);
    for (int i = 0; i < j; ++i) u(i) = (G(i, j) - R_.col(i).head(i).dot(u.head(i))) / R_(i, i);
    const double pivot = G(j, j) - u.squaredNorm();
    if (!(pivot > kFlatPivot * G(j, j))) return false;
    R_(j, j) = std::sqrt(pivot);
    auto column = J_.col(j).head(n);
    column.setZero();
    for (int i = 0; i < j; ++i) column.head(i + 1) -= u(i) * J_.col(i).head(i + 1);
    column(j) = 1;
    column.head(j + 1) /= R_(j, j);
  }
  x_.head(n).setZero();
  value_ = 0;
  for (int j = 0; j < n; ++j) {
    const auto column = J_.col(j).head(j + 1);
    const double slope = column.dot(g.head(j + 1));
    x_.head(j + 1) -= slope * column;
    value_ -= 0.5 * slope * slope;
  }
  return true;
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
  for (int j = 0; j < unknowns_; ++j) y += x_(j) * rows.matrix.col(j);
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
  for (int k = 0; k < n; ++k) d(k) = J_.col(k).head(n).dot(normal);
}

void DualQp::calcDirections() {
  const int n = unknowns_;
  const auto d = projected_.head(n);
  auto z = direction_.head(n);
  z.setZero();
  for (int k = count_; k < n; ++k) z += d(k) * J_.col(k).head(n);
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
  for (int k = q; k < n; ++k) J_.col(k).head(n) -= (factor * d(k - q)) * w;
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
    const double length = std::hypot(R_(k, k), R_(k + 1, k));
    const double c = R_(k, k) / length;
    const double s = R_(k + 1, k) / length;
    for (int j = k; j < count_; ++j) {
      const double above = R_(k, j);
      R_(k, j) = c * above + s * R_(k + 1, j);
      R_(k + 1, j) = c * R_(k + 1, j) - s * above;
    }
    auto left = J_.col(k).head(n);
    auto right = J_.col(k + 1).head(n);
    auto old_left = direction_.head(n);
    old_left = left;
    left = c * old_left + s * right;
    right = c * right - s * old_left;
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
