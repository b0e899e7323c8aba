#include "sinew/solver/dense_qp.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "sinew/solver/qp_residual.h"

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLift = 1e-4;        // curvature given to flat directions, against a largest scaled curvature of 1
constexpr double kPassEnded = 1e-12;  // pull of the last pass, against the gradient
constexpr double kLeastForce = 1e-6;  // gradient to compare with, where the objective has no slope
constexpr double kFlat = 1e-11;       // curvature and row rates of a unit direction of recession
constexpr double kDescent = 1e-9;     // slope of a unit direction, against the gradient

bool limitsAreValid(const Eigen::Ref<const VecX>& lower, const Eigen::Ref<const VecX>& upper) {
  return (lower.array() < kInfinity).all() && (upper.array() > -kInfinity).all();
}

bool isFinite(const QpProblem& problem) {
  const int n = problem.variables;
  const int m = problem.rows;
  return problem.G.topLeftCorner(n, n).allFinite() && problem.g.head(n).allFinite() &&
         problem.C.topLeftCorner(m, n).allFinite() && limitsAreValid(problem.lower.head(n), problem.upper.head(n)) &&
         limitsAreValid(problem.row_lower.head(m), problem.row_upper.head(m));
}

double calcLargest(const Eigen::Ref<const VecX>& v) {
  return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0;
}

/// Time in which a value that changes at `rate` meets its limit.
double calcRoom(double value, double rate, double lower, double upper) {
  if (rate > kFlat) return std::max(0.0, (upper - value) / rate);
  if (rate < -kFlat) return std::max(0.0, (lower - value) / rate);
  return kInfinity;
}

void clear(const QpProblem& problem, QpSolution& solution) {
  solution.x.head(problem.variables).setZero();
  solution.bound_dual.head(problem.variables).setZero();
  solution.row_dual.head(problem.rows).setZero();
  solution.objective = 0;
  solution.residual = 0;
  solution.iterations = 0;
  solution.passes = 0;
}

}  // namespace

DenseQp::DenseQp(int max_variables, int max_rows, const DenseQpSettings& settings)
    : settings_(settings),
      scaling_(max_variables, max_rows),
      scaled_(max_variables, max_rows),
      active_set_(max_variables, max_rows),
      centre_(max_variables),
      step_(max_variables),
      last_x_(max_variables),
      curvature_(max_variables) {}

void DenseQp::forget() {
  active_set_.forget();
  last_variables_ = -1;
}

QpStatus DenseQp::solve(const QpProblem& problem, QpSolution& solution) {
  assert(problem.variables <= centre_.size() && problem.rows <= scaling_.row.size());
  clear(problem, solution);
  if (!isFinite(problem)) return solution.status = QpStatus::kNotFinite;
  if (hasCrossingLimits(problem)) return solution.status = QpStatus::kInfeasible;

  updateScaling(problem, scaling_);
  scaleProblem(problem, scaling_, scaled_);
  solution.status = solveScaled(solution);
  if (solution.status == QpStatus::kSolved) reportPoint(problem, solution);
  if (solution.status == QpStatus::kUnbounded) reportDirection(solution);
  if (solution.status == QpStatus::kInfeasible) reportDuals(1 / calcLargest(active_set_.dual()), solution);
  if (solution.status != QpStatus::kSolved) forget();
  return solution.status;
}

QpStatus DenseQp::solveScaled(QpSolution& solution) {
  const int n = scaled_.variables;
  centre_.head(n).setZero();
  if (last_variables_ == n) centre_.head(n) = last_x_.head(n).cwiseQuotient(scaling_.unknown.head(n));
  active_set_.start(scaled_, kLift);
  for (solution.passes = 1; solution.passes <= settings_.max_passes; ++solution.passes) {
    const QpStatus status = active_set_.minimise(centre_.head(n), settings_.max_iterations);
    solution.iterations = active_set_.iterations();
    if (status != QpStatus::kSolved || !active_set_.factor().lifted()) return status;
    step_.head(n) = active_set_.x() - centre_.head(n);
    if (passesEnded()) return QpStatus::kSolved;
    const double reach = calcReach();
    if (reach == kInfinity) return QpStatus::kUnbounded;
    centre_.head(n) = active_set_.x() + reach * step_.head(n);
  }
  return QpStatus::kIterationLimit;
}

bool DenseQp::passesEnded() const {
  const int n = scaled_.variables;
  const auto x = active_set_.x();
  const double pull = active_set_.factor().proximal().cwiseProduct(step_.head(n)).cwiseAbs().maxCoeff();
  double force = std::max({kLeastForce, calcLargest(scaled_.g.head(n)), calcLargest(active_set_.dual())});
  for (int i = 0; i < n; ++i) force = std::max(force, scaled_.G.col(i).head(n).cwiseAbs().dot(x.cwiseAbs()));
  return pull <= kPassEnded * force;
}

/// Distance that the last step can go on, in steps of length one, while the objective falls at a constant rate: 0 if it
/// bends, infinite if no limit is met.
double DenseQp::calcReach() {
  const int n = scaled_.variables;
  const int m = scaled_.rows;
  auto step = step_.head(n);
  step /= calcLargest(step);
  if (scaled_.g.head(n).dot(step) >= -kDescent * calcLargest(scaled_.g.head(n))) return 0;
  curvature_.head(n).noalias() = scaled_.G.topLeftCorner(n, n) * step;
  if (calcLargest(curvature_.head(n)) > kFlat) return 0;
  double reach = kInfinity;
  for (int k = 0; k < n; ++k)
    reach = std::min(reach, calcRoom(active_set_.x()(k), step(k), scaled_.lower(k), scaled_.upper(k)));
  for (int j = 0; j < m; ++j) {
    const auto normal = scaled_.normals.col(j).head(n);
    reach = std::min(
        reach, calcRoom(normal.dot(active_set_.x()), normal.dot(step), scaled_.lower(n + j), scaled_.upper(n + j)));
  }
  return reach;
}

void DenseQp::reportPoint(const QpProblem& problem, QpSolution& solution) {
  const int n = problem.variables;
  auto x = solution.x.head(n);
  x = active_set_.x().cwiseProduct(scaling_.unknown.head(n));
  x = x.cwiseMax(problem.lower.head(n)).cwiseMin(problem.upper.head(n));
  reportDuals(1 / scaling_.objective, solution);
  curvature_.head(n).noalias() = problem.G.topLeftCorner(n, n) * x;
  solution.objective = x.dot(0.5 * curvature_.head(n) + problem.g.head(n));
  solution.residual = calcKktResidual(problem, scaling_, solution).worst();
  if (!(solution.residual <= settings_.accuracy)) solution.status = QpStatus::kIterationLimit;
  last_variables_ = n;
  last_x_.head(n) = x;
}

void DenseQp::reportDuals(double factor, QpSolution& solution) const {
  const int n = scaled_.variables;
  const int m = scaled_.rows;
  solution.bound_dual.head(n) = factor * active_set_.dual().head(n).cwiseQuotient(scaling_.unknown.head(n));
  solution.row_dual.head(m) = factor * active_set_.dual().tail(m).cwiseProduct(scaling_.row.head(m));
}

void DenseQp::reportDirection(QpSolution& solution) const {
  const int n = scaled_.variables;
  auto x = solution.x.head(n);
  x = step_.head(n).cwiseProduct(scaling_.unknown.head(n));
  x /= calcLargest(x);
}

}  // namespace sinew
