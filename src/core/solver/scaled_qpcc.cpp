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
      row_scale(capacity.contacts + capacity.rows),
      merged_(static_cast<std::size_t>(capacity.contacts), 0),
      motion_(capacity.unknowns),
      diagonal_(capacity.contacts) {
  rigid_.reserve(static_cast<std::size_t>(capacity.contacts));
}

void ScaledQpcc::update(const QpccProblem& problem) {
  size = problem.size;
  updateContacts(problem);
  updateContactUnits(problem);
  updateEffectorScale(problem);
  updateUnknownUnits(problem);
  updateRowScales(problem);
  updateMagnitude(problem);
  fillTable(problem);
  fillLimits(problem);
}

void ScaledQpcc::updateContacts(const QpccProblem& problem) {
  std::fill(merged_.begin(), merged_.end(), 0);
  rigid_.clear();
  for (int i = 0; i < problem.size.contacts; ++i) diagonal_(i) = problem.C_c(i, i);
  size.contacts = 0;
  for (int i = 0; i < problem.size.contacts; ++i) {
    if (!(problem.C_c(i, i) > 0)) {
      if (!problem.C_a.row(i).head(size.unknowns).isZero(0)) rigid_.push_back(i);
    } else if (isCovered(problem, i)) {
      merged_[static_cast<std::size_t>(i)] = 1;
    } else {
      contact[static_cast<std::size_t>(size.contacts++)] = i;
    }
  }
  size.rows = problem.size.rows + static_cast<int>(rigid_.size());
}

/// Whether contact i is k > 0 times another one that stays, with a gap no larger.
bool ScaledQpcc::isCovered(const QpccProblem& problem, int i) const {
  const auto& p = problem;
  const int n = p.size.contacts;
  const double C_ii = diagonal_(i);
  for (int j = 0; j < n; ++j) {
    const double C_jj = diagonal_(j);
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

void ScaledQpcc::updateContactUnits(const QpccProblem& problem) {
  for (int k = 0; k < size.contacts; ++k) contact_unit(k) = inverseOrOne(std::sqrt(problem.C_c(at(k), at(k))));
  for (int j = 0; j < size.unknowns; ++j) {
    motion_(j) = 0;
    for (int k = 0; k < size.contacts; ++k)
      motion_(j) = std::max(motion_(j), contact_unit(k) * std::abs(problem.C_a(at(k), j)));
  }
}

/// From what contact forces do to the effectors, or else from what x does to both.
void ScaledQpcc::updateEffectorScale(const QpccProblem& problem) {
  const int ne = size.effectors;
  double largest = 0;
  for (int k = 0; k < size.contacts && ne > 0; ++k)
    largest = std::max(largest, contact_unit(k) * problem.E_c.col(at(k)).head(ne).cwiseAbs().maxCoeff());
  for (int j = 0; j < size.unknowns && largest == 0 && ne > 0; ++j)
    largest = problem.E_a.col(j).head(ne).norm() / (motion_(j) > 0 ? motion_(j) : 1);
  effector_scale = inverseOrOne(largest);
}

void ScaledQpcc::updateUnknownUnits(const QpccProblem& problem) {
  for (int j = 0; j < size.unknowns; ++j) {
    const double error = problem.E_a.col(j).head(size.effectors).norm();
    const double curvature = effector_scale * std::hypot(error, std::sqrt(std::max(0.0, problem.Q(j, j))));
    double largest = std::max(motion_(j), curvature);
    for (int r = 0; r < problem.size.rows && largest == 0; ++r) largest = std::abs(problem.A_a(r, j));
    unknown_unit(j) = inverseOrOne(largest);
  }
}

void ScaledQpcc::updateRowScales(const QpccProblem& problem) {
  for (int r = 0; r < size.rows; ++r) {
    const int rigid = r - problem.size.rows;
    double largest = 0;
    for (int j = 0; j < size.unknowns; ++j) {
      const double entry = rigid < 0 ? problem.A_a(r, j) : problem.C_a(rigid_[static_cast<std::size_t>(rigid)], j);
      largest = std::max(largest, unknown_unit(j) * std::abs(entry));
    }
    for (int k = 0; k < size.contacts && rigid < 0; ++k)
      largest = std::max(largest, contact_unit(k) * std::abs(problem.A_c(r, at(k))));
    row_scale(r) = inverseOrOne(largest);
  }
}

void ScaledQpcc::updateMagnitude(const QpccProblem& problem) {
  double largest = 0;
  for (int k = 0; k < size.contacts; ++k) largest = std::max(largest, contact_unit(k) * std::abs(problem.c(at(k))));
  for (int r = 0; r < size.effectors; ++r) largest = std::max(largest, effector_scale * std::abs(problem.e(r)));
  for (int r = 0; r < problem.size.rows; ++r) {
    for (const double limit : {problem.row_lower(r), problem.row_upper(r)})
      if (largest == 0 && std::isfinite(limit)) largest = row_scale(r) * std::abs(limit - problem.a(r));
  }
  magnitude = 1 / inverseOrOne(largest);
}

void ScaledQpcc::fillTable(const QpccProblem& problem) {
  const int na = size.unknowns;
  const int nc = size.contacts;
  const int nr = problem.size.rows;
  const int ne = size.effectors;
  const auto fill = [&](int column, const auto& C, const auto& A, const auto& E, double unit) {
    auto out = table.col(column);
    for (int k = 0; k < nc; ++k) out(k) = C(at(k)) * (contact_unit(k) * unit);
    out.segment(nc, nr) = A.head(nr).cwiseProduct(row_scale.head(nr)) * unit;
    for (int r = nr; r < size.rows; ++r)
      out(nc + r) = C(rigid_[static_cast<std::size_t>(r - nr)]) * (row_scale(r) * unit);
    out.segment(limitedRows(), ne) = E.head(ne) * (effector_scale * unit);
  };
  for (int k = 0; k < nc; ++k)
    fill(k, problem.C_c.col(at(k)), problem.A_c.col(at(k)), problem.E_c.col(at(k)), contact_unit(k));
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
  const int nr = problem.size.rows;
  row_lower.head(limitedRows()).setZero();
  row_upper.head(limitedRows()).setConstant(kInfinity);
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
