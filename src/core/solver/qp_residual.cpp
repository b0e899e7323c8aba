#include "sinew/solver/qp_residual.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-12;
constexpr double kLeastScale = 1e-6;  // of points and gradients, where the objective has no slope to compare with

double calcRatio(double value, double scale) {
  return value > 0 ? value / scale : 0;
}

double calcMiss(double value, double lower, double upper) {
  return std::max({lower - value, value - upper, 0.0});
}

/// Largest distance to the feasible side, relative to the larger of its limit and the magnitude of all values.
class FeasibilityMeasure {
 public:
  explicit FeasibilityMeasure(double magnitude) : magnitude_(magnitude) {}

  void add(double value, double lower, double upper) {
    const double limit = value < lower ? lower : upper;
    worst_ = std::max(worst_, calcRatio(calcMiss(value, lower, upper), std::max(magnitude_, std::abs(limit))));
  }

  double worst() const { return worst_; }

 private:
  double magnitude_;
  double worst_ = 0;
};

/// Largest of min(|dual|, distance to its limit), both relative.
class ComplementarityMeasure {
 public:
  ComplementarityMeasure(double dual_magnitude, double magnitude)
      : dual_magnitude_(dual_magnitude), magnitude_(magnitude) {}

  void add(double value, double dual, double lower, double upper) {
    if (dual == 0) return;
    const double limit = dual > 0 ? lower : upper;
    const double distance =
        std::isfinite(limit) ? calcRatio(std::abs(value - limit), std::max(magnitude_, std::abs(limit))) : 1;
    worst_ = std::max(worst_, std::min(calcRatio(std::abs(dual), dual_magnitude_), distance));
  }

  double worst() const { return worst_; }

 private:
  double dual_magnitude_, magnitude_;
  double worst_ = 0;
};

bool limitsCross(double lower, double upper) {
  return lower - upper > kRounding * std::max(std::abs(lower), std::abs(upper));
}

double calcGapTerm(double dual, double lower, double upper) {
  if (dual == 0) return 0;
  const double limit = dual > 0 ? lower : upper;
  return std::isfinite(limit) ? dual * limit : -kInfinity;
}

}  // namespace

double KktResidual::worst() const {
  return std::max({stationarity, feasibility, complementarity});
}

bool hasCrossingLimits(const QpProblem& problem) {
  for (int i = 0; i < problem.variables; ++i)
    if (limitsCross(problem.lower(i), problem.upper(i))) return true;
  for (int j = 0; j < problem.rows; ++j)
    if (limitsCross(problem.row_lower(j), problem.row_upper(j))) return true;
  return false;
}

KktResidual calcKktResidual(const QpProblem& problem, const QpScaling& scaling, const QpSolution& solution) {
  const int n = problem.variables;
  const int m = problem.rows;
  const auto x = solution.x.head(n);
  const auto row_dual = solution.row_dual.head(m);
  if (!x.allFinite() || !row_dual.allFinite() || !solution.bound_dual.head(n).allFinite())
    return {kInfinity, kInfinity, kInfinity};

  double imbalance = 0;
  const double least = problem.g.head(n).isZero(0) ? kLeastScale : 0;
  double force = least;
  double magnitude = least;
  for (int i = 0; i < n; ++i) {
    const auto G_i = problem.G.col(i).head(n);
    const auto C_i = problem.C.col(i).head(m);
    const double unit = scaling.unknown(i) * scaling.objective;
    const double bound_dual = solution.bound_dual(i);
    const double gradient = G_i.dot(x) + problem.g(i);
    const double terms = G_i.cwiseAbs().dot(x.cwiseAbs()) + std::abs(problem.g(i)) + std::abs(bound_dual) +
                         C_i.cwiseAbs().dot(row_dual.cwiseAbs());
    imbalance = std::max(imbalance, unit * std::abs(gradient - bound_dual - C_i.dot(row_dual)));
    force = std::max(force, unit * terms);
    magnitude = std::max({magnitude, std::abs(x(i)) / scaling.unknown(i), unit * std::abs(problem.g(i))});
  }

  FeasibilityMeasure feasibility(magnitude);
  ComplementarityMeasure complementarity(force, magnitude);
  for (int i = 0; i < n; ++i) {
    const double unit = scaling.unknown(i);
    const double lower = problem.lower(i) / unit;
    const double upper = problem.upper(i) / unit;
    feasibility.add(x(i) / unit, lower, upper);
    complementarity.add(x(i) / unit, solution.bound_dual(i) * unit * scaling.objective, lower, upper);
  }
  for (int j = 0; j < m; ++j) {
    const double value = problem.C.row(j).head(n).dot(x) * scaling.row(j);
    const double lower = problem.row_lower(j) * scaling.row(j);
    const double upper = problem.row_upper(j) * scaling.row(j);
    feasibility.add(value, lower, upper);
    complementarity.add(value, row_dual(j) * scaling.objective / scaling.row(j), lower, upper);
  }
  return {calcRatio(imbalance, force), feasibility.worst(), complementarity.worst()};
}

InfeasibilityProof calcInfeasibilityProof(const QpProblem& problem, const QpScaling& scaling,
                                          const QpSolution& solution) {
  if (hasCrossingLimits(problem)) return {0, 1};
  const auto row_dual = solution.row_dual.head(problem.rows);

  double imbalance = 0;
  double force = 0;
  double gap = 0;
  double magnitude = 0;
  for (int i = 0; i < problem.variables; ++i) {
    const auto C_i = problem.C.col(i).head(problem.rows);
    const double dual = solution.bound_dual(i);
    imbalance = std::max(imbalance, scaling.unknown(i) * std::abs(dual + C_i.dot(row_dual)));
    force = std::max(force, scaling.unknown(i) * (std::abs(dual) + C_i.cwiseAbs().dot(row_dual.cwiseAbs())));
    const double term = calcGapTerm(dual, problem.lower(i), problem.upper(i));
    gap += term;
    magnitude += std::abs(term);
  }
  for (int j = 0; j < problem.rows; ++j) {
    const double term = calcGapTerm(row_dual(j), problem.row_lower(j), problem.row_upper(j));
    gap += term;
    magnitude += std::abs(term);
  }
  if (!std::isfinite(gap)) return {calcRatio(imbalance, force), -kInfinity};
  return {calcRatio(imbalance, force), magnitude > 0 ? gap / magnitude : 0};
}

}  // namespace sinew
