#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/solver/qp_problem.h"

/// Checks of QP answers, written from the definitions and apart from `sinew/solver/qp_residual.h`. They do not scale:
/// they are for problems whose entries are all of the order of one.
namespace sinew {

inline double largest(const VecX& v) {
  return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0;
}

/// Limit that the sign of a dual names.
inline double namedLimit(double dual, double lower, double upper) {
  return dual > 0 ? lower : upper;
}

inline VecX stack(const VecX& bounds, const VecX& rows) {
  VecX all(bounds.size() + rows.size());
  all << bounds, rows;
  return all;
}

/// Worst violation of the KKT conditions, relative to the largest of the terms of each (at least one).
inline double kktError(const QpProblem& problem, const QpSolution& solution) {
  const VecX force = problem.C.transpose() * solution.row_dual + solution.bound_dual;
  const VecX bent = problem.G * solution.x;
  const double force_scale = std::max({1.0, largest(bent), largest(problem.g), largest(force)});
  double worst = largest(bent + problem.g - force) / force_scale;

  const VecX values = stack(solution.x, problem.C * solution.x);
  const VecX duals = stack(solution.bound_dual, solution.row_dual);
  const VecX lower = stack(problem.lower, problem.row_lower);
  const VecX upper = stack(problem.upper, problem.row_upper);
  const double value_scale = std::max(1.0, largest(values));
  for (int k = 0; k < values.size(); ++k) {
    worst = std::max({worst, (lower(k) - values(k)) / value_scale, (values(k) - upper(k)) / value_scale});
    if (duals(k) == 0) continue;
    const double slack = std::abs(values(k) - namedLimit(duals(k), lower(k), upper(k)));
    worst = std::max(worst, std::min(slack / value_scale, std::abs(duals(k)) / force_scale));
  }
  return worst;
}

/// Error of an infeasibility certificate: what is left of C^T row_dual + bound_dual, relative to the largest dual;
/// infinity if the sum of dual * limit is not positive beyond rounding.
inline double certificateError(const QpProblem& problem, const QpSolution& solution) {
  const VecX duals = stack(solution.bound_dual, solution.row_dual);
  const VecX lower = stack(problem.lower, problem.row_lower);
  const VecX upper = stack(problem.upper, problem.row_upper);
  double gap = 0;
  double terms = 0;
  for (int k = 0; k < duals.size(); ++k) {
    if (duals(k) == 0) continue;
    const double term = duals(k) * namedLimit(duals(k), lower(k), upper(k));
    gap += term;
    terms += std::abs(term);
  }
  if (!(gap > 1e-9 * terms)) return std::numeric_limits<double>::infinity();
  return largest(problem.C.transpose() * solution.row_dual + solution.bound_dual) / largest(duals);
}

/// Error of a direction (largest entry 1) along which the QP is unbounded; infinity if the objective does not fall.
inline double directionError(const QpProblem& problem, const QpSolution& solution) {
  if (!(problem.g.dot(solution.x) < -1e-9)) return std::numeric_limits<double>::infinity();
  const VecX rates = stack(solution.x, problem.C * solution.x);
  const VecX lower = stack(problem.lower, problem.row_lower);
  const VecX upper = stack(problem.upper, problem.row_upper);
  double worst = largest(problem.G * solution.x);
  for (int k = 0; k < rates.size(); ++k) {
    if (std::isfinite(lower(k))) worst = std::max(worst, -rates(k));
    if (std::isfinite(upper(k))) worst = std::max(worst, rates(k));
  }
  return worst;
}

inline double relativeDifference(double value, double reference) {
  return std::abs(value - reference) / std::max(1.0, std::abs(reference));
}

}  // namespace sinew
