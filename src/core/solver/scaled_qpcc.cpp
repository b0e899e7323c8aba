#include "sinew/solver/scaled_qpcc.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kParallel = 1e-7;  // 1 - cosine of two normals worth a closer look
constexpr double kSame = 1e-9;      // entries of the same normal, in the units of their rows

double roundToPowerOfTwo(double value) {
  return std::ldexp(1.0, std::ilogb(value * std::sqrt(2.0)));
}

double inverseOrOne(double value) {
  return value > 0 && std::isfinite(1 / value) ? roundToPowerOfTwo(1 / value) : 1;
}

double calcRange(double lower, double upper, double unit) {
  if (std::isfinite(lower) && std::isfinite(upper) && upper > lower) return upper - lower;
  if (std::isfinite(lower) && lower != 0) return std::abs(lower);
  if (std::isfinite(upper) && upper != 0) return std::abs(upper);
  return unit;
}

}  // namespace

ScaledQpcc::ScaledQpcc(const QpccSizes& capacity)
    : table(capacity.contacts + capacity.rows + capacity.effectors, capacity.contacts + capacity.unknowns + 1),
      row_lower(capacity.contacts + capacity.rows),
      row_upper(capacity.contacts + capacity.rows),
      x_lower(capacity.unknowns),
      x_upper(capacity.unknowns),
      soft_lower(capacity.unknowns),
      soft_upper(capacity.unknowns),
      soft_range(capacity.unknowns),
      Q(capacity.unknowns, capacity.unknowns),
      q(capacity.unknowns),
      contact(static_cast<std::size_t>(capacity.contacts), 0),
      contact_unit(capacity.contacts),
      unknown_unit(capacity.unknowns),
      row_scale(capacity.rows),
      merged_(static_cast<std::size_t>(capacity.contacts), 0) {}

void ScaledQpcc::update(const QpccProblem& problem) {
  size = problem.size;
  updateContacts(problem);
  updateUnits(problem);
  updateMagnitude(problem);
  fillTable(problem);
  fillLimits(problem);
}

void ScaledQpcc::updateContacts(const QpccProblem& problem) {
  std::fill(merged_.begin(), merged_.end(), 0);
  size.contacts = 0;
  for (int i = 0; i < problem.size.contacts; ++i) {
    if (isCovered(problem, i))
      merged_[static_cast<std::size_t>(i)] = 1;
    else
      contact[static_cast<std::size_t>(size.contacts++)] = i;
  }
}

/// Whether contact i is k > 0 times another one that stays, with a gap no larger.
bool ScaledQpcc::isCovered(const QpccProblem& problem, int i) const {
  const auto& p = problem;
  const int n = p.size.contacts;
  const double C_ii = p.C_c(i, i);
  if (!(C_ii > 0)) return false;
  for (int j = 0; j < n; ++j) {
    const double C_jj = p.C_c(j, j);
    const double C_ij = p.C_c(j, i);
    if (j == i || !(C_ij > 0) || C_ij * C_ij < (1 - kParallel) * C_ii * C_jj) continue;
    const double k = C_ij / C_jj;
    if (p.c(i) < k * p.c(j) || merged_[static_cast<std::size_t>(j)]) continue;
    const auto differ = [k](const auto& own, const auto& other, double unit) {
      return own.size() > 0 && (own - k * other).cwiseAbs().maxCoeff() > kSame * unit;
    };
    const auto largest = [](const auto& v) { return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0; };
    const auto C_a = p.C_a.leftCols(p.size.unknowns);
    const auto C_c = p.C_c.topRows(n);
    const auto A_c = p.A_c.topRows(p.size.rows);
    const auto E_c = p.E_c.topRows(p.size.effectors);
    if (differ(C_a.row(i), C_a.row(j), largest(C_a.row(i)))) continue;
    if (differ(C_c.col(i), C_c.col(j), largest(C_c.col(i)))) continue;
    if (differ(A_c.col(i), A_c.col(j), largest(A_c.col(i)))) continue;
    if (differ(E_c.col(i), E_c.col(j), largest(E_c.col(i)))) continue;
    return true;
  }
  return false;
}

void ScaledQpcc::updateUnits(const QpccProblem& problem) {
  const int na = size.unknowns;
  const int ne = size.effectors;
  const int nr = size.rows;
  unknown_unit.head(na).setZero();  // first the largest motion that a unit of x causes
  double effector_motion = 0;       // largest that a unit of z causes
  for (int k = 0; k < size.contacts; ++k) {
    const int i = contact[static_cast<std::size_t>(k)];
    const double diagonal = problem.C_c(i, i);
    const double motion = na > 0 ? problem.C_a.row(i).head(na).cwiseAbs().maxCoeff() : 0;
    contact_unit(k) = diagonal > 0 ? inverseOrOne(std::sqrt(diagonal)) : inverseOrOne(motion);
    for (int j = 0; j < na; ++j)
      unknown_unit(j) = std::max(unknown_unit(j), contact_unit(k) * std::abs(problem.C_a(i, j)));
    if (ne > 0)
      effector_motion = std::max(effector_motion, contact_unit(k) * problem.E_c.col(i).head(ne).cwiseAbs().maxCoeff());
  }
  for (int j = 0; j < na && effector_motion == 0; ++j) {
    const double E_j = ne > 0 ? problem.E_a.col(j).head(ne).norm() : 0;
    effector_motion = unknown_unit(j) > 0 ? E_j / unknown_unit(j) : E_j;
  }
  effector_scale = inverseOrOne(effector_motion);
  for (int j = 0; j < na; ++j) {
    const double E_j = ne > 0 ? problem.E_a.col(j).head(ne).norm() : 0;
    const double A_j = nr > 0 ? problem.A_a.col(j).head(nr).cwiseAbs().maxCoeff() : 0;
    const double curvature = effector_scale * std::hypot(E_j, std::sqrt(std::max(0.0, problem.Q(j, j))));
    unknown_unit(j) = std::max(unknown_unit(j), curvature);
    unknown_unit(j) = inverseOrOne(unknown_unit(j) > 0 ? unknown_unit(j) : A_j);
  }
  for (int r = 0; r < nr; ++r) {
    double motion = 0;
    for (int j = 0; j < na; ++j) motion = std::max(motion, unknown_unit(j) * std::abs(problem.A_a(r, j)));
    for (int k = 0; k < size.contacts; ++k)
      motion = std::max(motion, contact_unit(k) * std::abs(problem.A_c(r, contact[static_cast<std::size_t>(k)])));
    row_scale(r) = inverseOrOne(motion);
  }
}

void ScaledQpcc::updateMagnitude(const QpccProblem& problem) {
  double largest = 0;
  for (int k = 0; k < size.contacts; ++k)
    largest = std::max(largest, contact_unit(k) * std::abs(problem.c(contact[static_cast<std::size_t>(k)])));
  for (int r = 0; r < size.effectors; ++r) largest = std::max(largest, effector_scale * std::abs(problem.e(r)));
  for (int r = 0; r < size.rows; ++r) {
    for (const double limit : {problem.row_lower(r), problem.row_upper(r)})
      if (largest == 0 && std::isfinite(limit)) largest = row_scale(r) * std::abs(limit - problem.a(r));
  }
  magnitude = 1 / inverseOrOne(largest);
}

void ScaledQpcc::fillTable(const QpccProblem& problem) {
  const int na = size.unknowns;
  const int nc = size.contacts;
  const int nr = size.rows;
  const int ne = size.effectors;
  const auto fill = [&](int column, const auto& C, const auto& A, const auto& E, double unit) {
    auto out = table.col(column);
    for (int k = 0; k < nc; ++k) out(k) = C(contact[static_cast<std::size_t>(k)]) * (contact_unit(k) * unit);
    out.segment(nc, nr) = A.head(nr).cwiseProduct(row_scale.head(nr)) * unit;
    out.segment(nc + nr, ne) = E.head(ne) * (effector_scale * unit);
  };
  for (int k = 0; k < nc; ++k) {
    const int i = contact[static_cast<std::size_t>(k)];
    fill(k, problem.C_c.col(i), problem.A_c.col(i), problem.E_c.col(i), contact_unit(k));
  }
  for (int j = 0; j < na; ++j)
    fill(nc + j, problem.C_a.col(j), problem.A_a.col(j), problem.E_a.col(j), unknown_unit(j));
  fill(nc + na, problem.c, problem.a, problem.e, 1 / magnitude);
  const double s = effector_scale * effector_scale;
  for (int j = 0; j < na; ++j) {
    Q.col(j).head(na) = problem.Q.col(j).head(na).cwiseProduct(unknown_unit.head(na)) * (unknown_unit(j) * s);
    q(j) = problem.q(j) * unknown_unit(j) * (s / magnitude);
  }
}

void ScaledQpcc::fillLimits(const QpccProblem& problem) {
  const int na = size.unknowns;
  const int nc = size.contacts;
  const int nr = size.rows;
  row_lower.head(nc).setZero();
  row_upper.head(nc).setConstant(kInfinity);
  row_lower.segment(nc, nr) = problem.row_lower.head(nr).cwiseProduct(row_scale.head(nr)) / magnitude;
  row_upper.segment(nc, nr) = problem.row_upper.head(nr).cwiseProduct(row_scale.head(nr)) / magnitude;
  const auto unit = magnitude * unknown_unit.head(na);
  x_lower.head(na) = problem.x_lower.head(na).cwiseQuotient(unit);
  x_upper.head(na) = problem.x_upper.head(na).cwiseQuotient(unit);
  soft_lower.head(na) = problem.soft_lower.head(na).cwiseQuotient(unit);
  soft_upper.head(na) = problem.soft_upper.head(na).cwiseQuotient(unit);
  for (int j = 0; j < na; ++j) soft_range(j) = calcRange(soft_lower(j), soft_upper(j), 1);
}

}  // namespace sinew
