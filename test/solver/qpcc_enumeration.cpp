#include "qpcc_enumeration.h"

#include <algorithm>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Duplicate contacts leave the objective nearly flat, where proximal passes are slow.
DenseQpSettings makeSettings() {
  DenseQpSettings settings;
  settings.max_passes *= 10;
  return settings;
}

}  // namespace

FullQpcc::FullQpcc(const QpccProblem& p)
    : problem_(p),
      qp_(p.size.unknowns + p.size.contacts, p.size.rows + p.size.contacts),
      solution_(qp_.variables, qp_.rows),
      solver_(qp_.variables, qp_.rows, makeSettings()),
      point_(VecX::Zero(qp_.variables)) {
  const int na = p.size.unknowns;
  const int nc = p.size.contacts;
  MatX E(p.size.effectors, na + nc);
  E << p.E_a, p.E_c;
  qp_.G = E.transpose() * E;
  qp_.G.topLeftCorner(na, na) += p.Q;
  qp_.g = E.transpose() * p.e;
  qp_.g.head(na) += p.q;
  qp_.C << p.A_a, p.A_c, p.C_a, p.C_c;
  qp_.row_lower.head(p.size.rows) = p.row_lower - p.a;
  qp_.row_upper.head(p.size.rows) = p.row_upper - p.a;
}

void FullQpcc::setPiece(const std::vector<char>& active, bool soft) {
  const QpccProblem& p = problem_;
  const int na = p.size.unknowns;
  const int nr = p.size.rows;
  qp_.lower.head(na) = soft ? p.x_lower.cwiseMax(p.soft_lower).eval() : p.x_lower;
  qp_.upper.head(na) = soft ? p.x_upper.cwiseMin(p.soft_upper).eval() : p.x_upper;
  for (int i = 0; i < p.size.contacts; ++i) {
    const bool presses = active[static_cast<std::size_t>(i)] != 0;
    qp_.lower(na + i) = 0;
    qp_.upper(na + i) = presses ? kInfinity : 0;
    qp_.row_lower(nr + i) = -p.c(i);
    qp_.row_upper(nr + i) = presses ? -p.c(i) : kInfinity;
  }
}

double FullQpcc::solvePiece(const std::vector<char>& active, bool soft) {
  setPiece(active, soft);
  solver_.forget();
  if (solver_.solve(qp_, solution_) != QpStatus::kSolved) return kInfinity;
  point_ = solution_.x;
  return solution_.objective + 0.5 * problem_.e.squaredNorm();
}

double FullQpcc::enumerate(bool soft) {
  double best = kInfinity;
  VecX best_point = point_;
  for (unsigned bits = 0; bits < 1u << problem_.size.contacts; ++bits) {
    const double objective = solvePiece(activeSetOf(bits, problem_.size.contacts), soft);
    if (objective >= best) continue;
    best = objective;
    best_point = point_;
  }
  point_ = best_point;
  return best;
}

double FullQpcc::enumerateSoftViolation() {
  const QpccProblem& p = problem_;
  const int na = p.size.unknowns;
  const int n = qp_.variables;
  const int m = qp_.rows;
  const VecX range = p.soft_upper - p.soft_lower;
  QpProblem least(n + 1, m + 2 * na);
  least.g(n) = 1;
  least.lower(n) = 0;
  least.C.topLeftCorner(m, n) = qp_.C;
  least.C.block(m, 0, na, na).setIdentity();
  least.C.block(m + na, 0, na, na) = -MatX::Identity(na, na);
  least.C.col(n).segment(m, na) = range;
  least.C.col(n).segment(m + na, na) = range;
  least.row_lower.segment(m, na) = p.soft_lower;
  least.row_lower.segment(m + na, na) = -p.soft_upper;
  QpSolution solution(n + 1, m + 2 * na);
  DenseQp solver(n + 1, m + 2 * na);
  double best = kInfinity;
  for (unsigned bits = 0; bits < 1u << p.size.contacts; ++bits) {
    setPiece(activeSetOf(bits, p.size.contacts), false);
    least.lower.head(n) = qp_.lower;
    least.upper.head(n) = qp_.upper;
    least.row_lower.head(m) = qp_.row_lower;
    least.row_upper.head(m) = qp_.row_upper;
    solver.forget();
    if (solver.solve(least, solution) == QpStatus::kSolved) best = std::min(best, solution.x(n));
  }
  return best;
}

QpccResiduals calcResiduals(const QpccProblem& p, const VecX& x, const VecX& z) {
  QpccResiduals residuals;
  const VecX g = p.C_a * x + p.C_c * z + p.c;
  const auto largest = [](const VecX& v) { return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0; };
  const double force = std::max(largest(z), 1e-300);
  const double length = std::max(largest(p.c), 1e-300);
  for (int i = 0; i < z.size(); ++i) {
    residuals.gap = std::max(residuals.gap, -g(i));
    residuals.force = std::max(residuals.force, -z(i) / force);
    residuals.complementarity = std::max(residuals.complementarity, std::abs(z(i) * g(i)) / (force * length));
  }
  const VecX rows = p.A_a * x + p.A_c * z + p.a;
  const VecX terms = p.A_a.cwiseAbs() * x.cwiseAbs() + p.A_c.cwiseAbs() * z.cwiseAbs() + p.a.cwiseAbs();
  for (int r = 0; r < rows.size(); ++r) {
    const double miss = std::max(p.row_lower(r) - rows(r), rows(r) - p.row_upper(r));
    const double limit = rows(r) < p.row_lower(r) ? p.row_lower(r) : p.row_upper(r);
    residuals.limits = std::max(residuals.limits, miss / std::max({terms(r), std::abs(limit), 1e-300}));
  }
  for (int j = 0; j < x.size(); ++j)
    if (x(j) < p.x_lower(j) || x(j) > p.x_upper(j)) residuals.limits = kInfinity;
  residuals.objective = 0.5 * (p.E_a * x + p.E_c * z + p.e).squaredNorm() + x.dot(0.5 * (p.Q * x) + p.q);
  return residuals;
}

std::vector<char> activeSetOf(unsigned bits, int contacts) {
  std::vector<char> active(static_cast<std::size_t>(contacts), 0);
  for (int i = 0; i < contacts; ++i) active[static_cast<std::size_t>(i)] = (bits >> i) & 1u;
  return active;
}

}  // namespace sinew
