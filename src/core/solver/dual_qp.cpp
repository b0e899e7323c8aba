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
      N_(max_unknowns, max_unknowns),
      x_(max_unknowns),
      unknown_(static_cast<std::size_t>(max_unknowns), 0),
      place_(static_cast<std::size_t>(max_unknowns), 0),
      side_(max_unknowns),
      bound_dual_(max_unknowns),
      fixed_bound_(static_cast<std::size_t>(max_unknowns), 0),
      dual_(max_unknowns),
      sign_(max_unknowns),
      row_(static_cast<std::size_t>(max_unknowns), 0),
      fixed_(static_cast<std::size_t>(max_unknowns), 0),
      values_(max_rows + max_unknowns),
      misses_(max_rows + max_unknowns),
      normal_(max_unknowns),
      projected_(max_unknowns),
      direction_(max_unknowns),
      dual_direction_(max_unknowns),
      bound_rate_(max_unknowns),
      work_(max_unknowns),
      spilled_(max_unknowns),
      pull_(max_unknowns),
      listed_(static_cast<std::size_t>(max_unknowns), 0) {}

bool DualQp::start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, QpInterruption* interruption) {
  return start(G, g, {}, interruption);
}

bool DualQp::start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, const std::vector<char>& held,
                   QpInterruption* interruption) {
  const int n = unknowns_ = static_cast<int>(g.size());
  G_ = G.data();
  G_stride_ = static_cast<int>(G.outerStride());
  rows_ = count_ = steps_ = free_ = 0;
  for (int i = 0; i < n; ++i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const bool holds = !held.empty() && held[at] != 0;
    side_(i) = holds ? 1 : 0;
    place_[at] = holds ? -1 : free_;
    fixed_bound_[at] = 0;
    if (!holds) unknown_[static_cast<std::size_t>(free_++)] = i;
  }
  if (!factorise(interruption)) return false;
  invert();
  return release(g);
}

/// G_ff = U U^T, U upper triangular and in R_ for now.
bool DualQp::factorise(QpInterruption* interruption) {
  for (int j = free_ - 1; j >= 0; --j) {
    if (interruption && interruption->due()) return false;
    const double* column = G_ + unknownAt(j) * G_stride_;
    const double diagonal = column[unknownAt(j)];
    auto u = R_.col(j).head(j);
    for (int i = 0; i < j; ++i) u(i) = column[unknownAt(i)];
    const int later = free_ - 1 - j;
    auto row = work_.head(later);
    row = -R_.row(j).segment(j + 1, later).transpose();
    const double pivot = diagonal - row.squaredNorm();
    if (later > 0) kernels_->addColumns(&R_(0, j + 1), stride(), j, row.data(), later, u.data());
    if (!(pivot > kFlatPivot * diagonal)) return false;
    R_(j, j) = std::sqrt(pivot);
    u /= R_(j, j);
  }
  return true;
}

/// J = U^-T
void DualQp::invert() {
  for (int j = 0; j < free_; ++j) {
    auto column = work_.head(j + 1);
    column.setZero();
    column(j) = 1;
    for (int k = j; k >= 0; --k) {
      column(k) /= R_(k, k);
      column.head(k) -= column(k) * R_.col(k).head(k);
    }
    J_.row(j).head(j + 1) = column.transpose();
    J_.row(j).segment(j + 1, free_ - j - 1).setZero();
  }
}

/// Lets go of held unknowns until no dual is negative, the most negative first.
bool DualQp::release(const Eigen::Ref<const VecX>& g) {
  const int n = unknowns_;
  auto duals = bound_dual_.head(n);
  for (;;) {
    gatherFree(g, work_);
    kernels_->multiplyColumns(J_.data(), stride(), free_, work_.data(), free_, projected_.data());
    direction_.head(free_).setZero();
    projected_.head(free_) *= -1;
    kernels_->addColumns(J_.data(), stride(), free_, projected_.data(), free_, direction_.data());
    duals = g;
    kernels_->addListed(G_, G_stride_, n, unknown_.data(), direction_.data(), free_, duals.data());
    duals.array() *= side_.head(n).array();
    int worst = 0;
    if (n == 0 || duals.minCoeff(&worst) >= 0) break;
    if (!letGo(worst)) return false;
  }
  x_.head(n).setZero();
  for (int p = 0; p < free_; ++p) x_(unknownAt(p)) = direction_(p);
  value_ = -0.5 * projected_.head(free_).squaredNorm();
  return true;
}

/// Adds a row and a column to J. False where the objective is flat.
bool DualQp::letGo(int unknown) {
  const int f = free_;
  const double* column = G_ + unknown * G_stride_;
  auto y = direction_.head(f);  // G_ff^-1 times the column, refined once
  y.setZero();
  for (int pass = 0; pass < 2; ++pass) {
    auto missing = pull_.head(unknowns_);
    missing.setZero();
    kernels_->addListed(G_, G_stride_, unknowns_, unknown_.data(), direction_.data(), f, pull_.data());
    for (int p = 0; p < f; ++p) work_(p) = column[unknownAt(p)] - missing(unknownAt(p));
    kernels_->multiplyColumns(J_.data(), stride(), f, work_.data(), f, projected_.data());
    kernels_->addColumns(J_.data(), stride(), f, projected_.data(), f, direction_.data());
  }
  double pivot = column[unknown];
  for (int p = 0; p < f; ++p) pivot -= column[unknownAt(p)] * y(p);
  if (!(pivot > kFlatPivot * column[unknown])) return false;

  const double scale = 1 / std::sqrt(pivot);
  J_.col(f).head(f) = -scale * y;
  J_.row(f).head(f).setZero();
  J_(f, f) = scale;
  unknown_[static_cast<std::size_t>(f)] = unknown;
  place_[static_cast<std::size_t>(unknown)] = f;
  side_(unknown) = bound_dual_(unknown) = 0;
  ++free_;
  // The new column is not yet normal to the active rows.
  for (int k = 0; k < count_; ++k) {
    double entry = 0;
    for (int p = 0; p < free_; ++p) entry += J_(p, f) * N_(unknownAt(p), k);
    spilled_(k) = entry;
  }
  for (int k = 0; k < count_; ++k) {
    const double length = std::sqrt(R_(k, k) * R_(k, k) + spilled_(k) * spilled_(k));
    rotate(k, f, R_(k, k) / length, spilled_(k) / length);
  }
  return true;
}

/// Takes the unknown of the projected normal out of J, after turning J so that one column alone holds it.
void DualQp::hold(int unknown) {
  const int place = place_[static_cast<std::size_t>(unknown)];
  const int q = count_;
  reflect();
  spilled_.head(q).setZero();
  for (int k = q - 1; k >= 0; --k) {
    const double length = std::sqrt(J_(place, k) * J_(place, k) + J_(place, q) * J_(place, q));
    rotate(k, q, J_(place, q) / length, -J_(place, k) / length);
  }
  const int last = --free_;
  if (q != last) J_.col(q).head(last + 1) = J_.col(last).head(last + 1);
  J_.row(place).head(last) = J_.row(last).head(last);
  unknown_[static_cast<std::size_t>(place)] = unknownAt(last);
  place_[static_cast<std::size_t>(unknownAt(last))] = place;
  place_[static_cast<std::size_t>(unknown)] = -1;
}

void DualQp::copy(const DualQp& other) {
  const int n = unknowns_ = other.unknowns_;
  rows_ = other.rows_;
  free_ = other.free_;
  count_ = other.count_;
  steps_ = other.steps_;
  value_ = other.value_;
  G_ = other.G_;
  G_stride_ = other.G_stride_;
  for (int k = 0; k < free_; ++k) J_.col(k).head(free_) = other.J_.col(k).head(free_);
  for (int k = 0; k < count_; ++k) {
    R_.col(k).head(k + 1) = other.R_.col(k).head(k + 1);
    N_.col(k).head(n) = other.N_.col(k).head(n);
  }
  x_.head(n) = other.x_.head(n);
  side_.head(n) = other.side_.head(n);
  bound_dual_.head(n) = other.bound_dual_.head(n);
  dual_.head(count_) = other.dual_.head(count_);
  sign_.head(count_) = other.sign_.head(count_);
  std::copy_n(other.unknown_.begin(), free_, unknown_.begin());
  std::copy_n(other.place_.begin(), n, place_.begin());
  std::copy_n(other.fixed_bound_.begin(), n, fixed_bound_.begin());
  std::copy_n(other.row_.begin(), count_, row_.begin());
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
    updateNormal(rows, violation);
    const Outcome outcome = enforce(limits, violation, cutoff);
    if (outcome != Outcome::kOptimal) return outcome;
  }
}

void DualQp::updateValues(const QpRows& rows) {
  int count = 0;
  for (int i = 0; i < unknowns_; ++i) {
    if (x_(i) == 0) continue;
    listed_[static_cast<std::size_t>(count)] = i;
    work_(count++) = x_(i);
  }
  values_.head(rows_) = rows.constant;
  kernels_->addListed(rows.matrix.data(), static_cast<int>(rows.matrix.outerStride()), rows_, listed_.data(),
                      work_.data(), count, values_.data());
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
    const int row = activeRow(k);
    misses(row) = sign_(k) > 0 ? values(row) - limits.upper(row) : limits.lower(row) - values(row);
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

void DualQp::updateNormal(const QpRows& rows, const Violation& violation) {
  auto normal = normal_.head(unknowns_);
  if (violation.limit < rows_) {
    normal = violation.sign * rows.matrix.row(violation.limit).transpose();
  } else {
    normal.setZero();
    normal(violation.limit - rows_) = violation.sign;
  }
}

void DualQp::project() {
  gatherFree(normal_, work_);
  kernels_->multiplyColumns(J_.data(), stride(), free_, work_.data(), free_, projected_.data());
}

/// A dual of a held unknown loses what the others leave of the normal there: side (n - N r - G z).
void DualQp::calcDirections() {
  const auto d = projected_.head(free_);
  direction_.head(free_).setZero();
  if (count_ < free_) {
    kernels_->addColumns(&J_(0, count_), stride(), free_, &d(count_), free_ - count_, direction_.data());
  }
  free_curvature_ = d.tail(free_ - count_).squaredNorm();
  auto r = dual_direction_.head(count_);
  r = d.head(count_);
  for (int k = count_ - 1; k >= 0; --k) {
    r(k) /= R_(k, k);
    r.head(k) -= r(k) * R_.col(k).head(k);
  }
  auto pull = pull_.head(unknowns_);
  pull = -normal_.head(unknowns_);
  kernels_->addColumns(N_.data(), stride(), unknowns_, r.data(), count_, pull.data());
  kernels_->addListed(G_, G_stride_, unknowns_, unknown_.data(), direction_.data(), free_, pull.data());
  bound_rate_.head(unknowns_) = -pull.cwiseProduct(side_.head(unknowns_));
}

DualQp::Blocking DualQp::findBlocking() const {
  Blocking first{-1, kInfinity};
  const auto see = [&first](int limit, double dual, double rate) {
    if (rate > kBlocking && dual < first.length * rate) first = {limit, std::max(0.0, dual) / rate};
  };
  for (int k = 0; k < count_; ++k)
    if (!fixed_[static_cast<std::size_t>(k)]) see(k, dual_(k), dual_direction_(k));
  for (int i = 0; i < unknowns_; ++i)
    if (!fixed_bound_[static_cast<std::size_t>(i)]) see(count_ + i, bound_dual_(i), bound_rate_(i));
  return first;
}

DualQp::Outcome DualQp::enforce(const QpLimits& limits, Violation violation, double cutoff) {
  const int max_steps = 60 + 20 * unknowns_ + rows_;
  double dual = 0;
  project();
  for (;;) {
    if (++steps_ > max_steps) return Outcome::kFailed;
    calcDirections();
    const Blocking blocking = findBlocking();
    const bool dependent = !(free_curvature_ > kDependent * projected_.head(free_).squaredNorm());
    const double full = dependent ? kInfinity : violation.amount / free_curvature_;
    const double step = std::min(full, blocking.length);
    if (step == kInfinity) return Outcome::kInfeasible;

    dual_.head(count_) -= step * dual_direction_.head(count_);
    bound_dual_.head(unknowns_) -= step * bound_rate_.head(unknowns_);
    if (!dependent) {
      for (int p = 0; p < free_; ++p) x_(unknownAt(p)) += step * direction_(p);
      value_ += step * free_curvature_ * (0.5 * step + dual);
      violation.amount -= step * free_curvature_;
    }
    dual += step;
    const bool done = full <= blocking.length;
    if (done) activate(limits, violation, dual);
    if (value_ > cutoff) return Outcome::kCutOff;
    if (done) return Outcome::kOptimal;
    if (!drop(blocking.limit)) return Outcome::kFailed;
    project();
  }
}

bool DualQp::drop(int blocking) {
  if (blocking >= count_) return letGo(blocking - count_);
  remove(blocking);
  return true;
}

void DualQp::activate(const QpLimits& limits, const Violation& violation, double dual) {
  const bool fixed = limits.lower(violation.limit) == limits.upper(violation.limit);
  if (violation.limit < rows_) {
    row_[static_cast<std::size_t>(count_)] = violation.limit;
    fixed_[static_cast<std::size_t>(count_)] = fixed ? 1 : 0;
    sign_(count_) = violation.sign;
    dual_(count_) = dual;
    append();
  } else {
    const int unknown = violation.limit - rows_;
    hold(unknown);
    fixed_bound_[static_cast<std::size_t>(unknown)] = fixed ? 1 : 0;
    side_(unknown) = violation.sign;
    bound_dual_(unknown) = dual;
    x_(unknown) = violation.sign > 0 ? limits.lower(violation.limit) : limits.upper(violation.limit);
  }
}

/// Brings J2^T n_f onto its first entry, which is returned. J2 times the vector of the Householder reflection is the
/// primal direction but for one column.
double DualQp::reflect() {
  const int q = count_;
  auto d = projected_.segment(q, free_ - q);
  const double length = std::sqrt(free_curvature_);
  const double pivot = d(0) > 0 ? -length : length;
  auto w = direction_.head(free_);
  w -= pivot * J_.col(q).head(free_);
  w /= free_curvature_ - pivot * d(0);
  d(0) -= pivot;
  kernels_->subtractOuter(&J_(0, q), stride(), free_, w.data(), d.data(), free_ - q);
  return pivot;
}

void DualQp::append() {
  R_.col(count_).head(count_) = projected_.head(count_);
  R_(count_, count_) = reflect();
  N_.col(count_).head(unknowns_) = normal_.head(unknowns_);
  ++count_;
}

void DualQp::remove(int position) {
  for (int k = position + 1; k < count_; ++k) {
    R_.col(k - 1).head(k + 1) = R_.col(k).head(k + 1);
    N_.col(k - 1).head(unknowns_) = N_.col(k).head(unknowns_);
    dual_(k - 1) = dual_(k);
    sign_(k - 1) = sign_(k);
    row_[static_cast<std::size_t>(k - 1)] = row_[static_cast<std::size_t>(k)];
    fixed_[static_cast<std::size_t>(k - 1)] = fixed_[static_cast<std::size_t>(k)];
  }
  --count_;
  // Rotations bring the columns that moved back to upper triangular form.
  for (int k = position; k < count_; ++k) {
    const double length = std::sqrt(R_(k, k) * R_(k, k) + R_(k + 1, k) * R_(k + 1, k));
    const double c = R_(k, k) / length;
    const double s = R_(k + 1, k) / length;
    for (int j = k; j < count_; ++j) {
      const double above = R_(k, j);
      R_(k, j) = c * above + s * R_(k + 1, j);
      R_(k + 1, j) = c * R_(k + 1, j) - s * above;
    }
    kernels_->rotate(&J_(0, k), &J_(0, k + 1), free_, c, s);
  }
}

/// Turns column k of J and another one that no active row sees, but for what R spills into its row.
void DualQp::rotate(int k, int other, double c, double s) {
  for (int j = k; j < count_; ++j) {
    const double above = R_(k, j);
    R_(k, j) = c * above + s * spilled_(j);
    spilled_(j) = c * spilled_(j) - s * above;
  }
  kernels_->rotate(&J_(0, k), &J_(0, other), free_, c, s);
}

void DualQp::settle(const QpRows& rows, const QpLimits& limits) {
  updateValues(rows);
  // N^T dx = what is missing, with dx = J1 R^-T (...).
  auto t = dual_direction_.head(count_);
  for (int k = 0; k < count_; ++k) {
    const int row = activeRow(k);
    const double at = sign_(k) > 0 ? limits.lower(row) : limits.upper(row);
    t(k) = (sign_(k) * (at - values_(row)) - R_.col(k).head(k).dot(t.head(k))) / R_(k, k);
  }
  for (int k = 0; k < count_; ++k)
    for (int p = 0; p < free_; ++p) x_(unknownAt(p)) += t(k) * J_(p, k);
  updateValues(rows);
}

}  // namespace sinew
