#include "sinew/solver/qp_scaling.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

constexpr int kMaxPasses = 8;

double inverseOrOne(double value) {
  return value > 0 ? 1 / value : 1;
}

double roundToPowerOfTwo(double value) {
  return std::ldexp(1.0, std::ilogb(value * std::sqrt(2.0)));
}

double calcLargestInColumn(const QpProblem& problem, int i) {
  return problem.rows > 0 ? problem.C.col(i).head(problem.rows).cwiseAbs().maxCoeff() : 0;
}

void updateRowScales(const QpProblem& problem, QpScaling& scaling) {
  auto row = scaling.row.head(problem.rows).array();
  row.setZero();
  for (int i = 0; i < problem.variables; ++i)
    row = row.max(problem.C.col(i).head(problem.rows).array().abs() * scaling.unknown(i));
  row = row.unaryExpr(&inverseOrOne);
}

void updateObjectiveScale(const QpProblem& problem, QpScaling& scaling) {
  const int n = problem.variables;
  const auto unknown = scaling.unknown.head(n).array();
  if (n == 0) return;
  double unit = (problem.G.diagonal().head(n).array() * unknown * unknown).maxCoeff();
  if (unit <= 0) unit = (problem.g.head(n).array().abs() * unknown).maxCoeff();
  scaling.objective = inverseOrOne(unit);
}

/// Factor by which the unknown is too large a unit: the geometric mean of what G and C say, as far as they say it.
double calcExcess(const QpProblem& problem, const QpScaling& scaling, int i) {
  const double unit = scaling.unknown(i);
  const double by_objective = std::sqrt(std::max(problem.G(i, i), 0.0) * scaling.objective) * unit;
  const double by_rows =
      problem.rows > 0
          ? (problem.C.col(i).head(problem.rows).array().abs() * scaling.row.head(problem.rows).array()).maxCoeff() *
                unit
          : 0;
  if (by_objective > 0 && by_rows > 0) return std::sqrt(by_objective * by_rows);
  if (by_objective > 0) return by_objective;
  return by_rows > 0 ? by_rows : 1;
}

}  // namespace

QpScaling::QpScaling(int max_variables, int max_rows) : unknown(VecX::Ones(max_variables)), row(VecX::Ones(max_rows)) {}

void updateScaling(const QpProblem& problem, QpScaling& scaling) {
  scaling.objective = 1;
  for (int i = 0; i < problem.variables; ++i) {
    const double diagonal = problem.G(i, i);
    scaling.unknown(i) = diagonal > 0 ? 1 / std::sqrt(diagonal) : inverseOrOne(calcLargestInColumn(problem, i));
  }
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    updateRowScales(problem, scaling);
    updateObjectiveScale(problem, scaling);
    double least = 1;
    double most = 1;
    for (int i = 0; i < problem.variables; ++i) {
      const double excess = calcExcess(problem, scaling, i);
      scaling.unknown(i) /= excess;
      least = std::min(least, excess);
      most = std::max(most, excess);
    }
    if (most < 8 * least) break;
  }
  for (int i = 0; i < problem.variables; ++i) scaling.unknown(i) = roundToPowerOfTwo(scaling.unknown(i));
  updateRowScales(problem, scaling);
  updateObjectiveScale(problem, scaling);
  for (int j = 0; j < problem.rows; ++j) scaling.row(j) = roundToPowerOfTwo(scaling.row(j));
  scaling.objective = roundToPowerOfTwo(scaling.objective);
}

ScaledQp::ScaledQp(int max_variables, int max_rows)
    : G(max_variables, max_variables),
      g(max_variables),
      normals(max_variables, max_rows),
      lower(max_variables + max_rows),
      upper(max_variables + max_rows) {}

void scaleProblem(const QpProblem& problem, const QpScaling& scaling, ScaledQp& scaled) {
  const int n = problem.variables;
  const int m = problem.rows;
  scaled.variables = n;
  scaled.rows = m;
  const auto unknown = scaling.unknown.head(n);
  const auto row = scaling.row.head(m);
  for (int j = 0; j < n; ++j)
    scaled.G.col(j).head(n) = problem.G.col(j).head(n).cwiseProduct(unknown) * (unknown(j) * scaling.objective);
  scaled.g.head(n) = problem.g.head(n).cwiseProduct(unknown) * scaling.objective;
  for (int i = 0; i < n; ++i)
    scaled.normals.row(i).head(m) = (problem.C.col(i).head(m).cwiseProduct(row) * unknown(i)).transpose();
  scaled.lower.head(n) = problem.lower.head(n).cwiseQuotient(unknown);
  scaled.upper.head(n) = problem.upper.head(n).cwiseQuotient(unknown);
  scaled.lower.segment(n, m) = problem.row_lower.head(m).cwiseProduct(row);
  scaled.upper.segment(n, m) = problem.row_upper.head(m).cwiseProduct(row);
  scaled.upper.head(n + m) = scaled.upper.head(n + m).cwiseMax(scaled.lower.head(n + m));
}

}  // namespace sinew
