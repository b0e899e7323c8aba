#include "solver/random_qp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool chance(double probability, std::mt19937& random) {
  return std::bernoulli_distribution(probability)(random);
}

int drawInteger(int least, int most, std::mt19937& random) {
  return std::uniform_int_distribution<int>(least, most)(random);
}

double drawReal(double least, double most, std::mt19937& random) {
  return std::uniform_real_distribution<double>(least, most)(random);
}

double drawNormal(std::mt19937& random) {
  return std::normal_distribution<double>()(random);
}

MatX drawIntegers(int rows, int columns, int largest, double density, std::mt19937& random) {
  MatX result(rows, columns);
  for (int j = 0; j < columns; ++j)
    for (int i = 0; i < rows; ++i) result(i, j) = chance(density, random) ? drawInteger(-largest, largest, random) : 0;
  return result;
}

MatX drawNormals(int rows, int columns, std::mt19937& random) {
  MatX result(rows, columns);
  for (int j = 0; j < columns; ++j)
    for (int i = 0; i < rows; ++i) result(i, j) = drawNormal(random);
  return result;
}

/// Limits around a value that they either just admit or, now and then, exclude.
void drawIntegerLimits(double value, double exclusion, std::mt19937& random, double& lower, double& upper) {
  const int spread = chance(exclusion, random) ? -2 : 0;
  lower = chance(0.5, random) ? value - drawInteger(spread, 2, random) : -kInfinity;
  upper = chance(0.5, random) ? value + drawInteger(spread, 2, random) : kInfinity;
  if (chance(0.08, random)) lower = upper = value;
  if (lower > upper) std::swap(lower, upper);
}

/// Distance between 1e-6 and 10, any order of magnitude alike.
double drawMargin(std::mt19937& random) {
  return 1.01 * std::pow(10.0, drawReal(-6, 1, random));
}

void drawLimits(double value, double share, std::mt19937& random, double& lower, double& upper) {
  lower = chance(share, random) ? value - drawMargin(random) : -kInfinity;
  upper = chance(share, random) ? value + drawMargin(random) : kInfinity;
}

}  // namespace

QpProblem makeIntegerQp(int variables, int rows, std::mt19937& random) {
  QpProblem problem(variables, rows);
  const MatX factor = drawIntegers(drawInteger(0, variables, random), variables, 2, 0.7, random);
  problem.G = factor.transpose() * factor;
  problem.g = drawIntegers(variables, 1, 5, 0.8, random);
  if (chance(0.5, random)) problem.g = problem.G * drawIntegers(variables, 1, 2, 0.8, random);
  const VecX point = drawIntegers(variables, 1, 3, 0.7, random);
  const double exclusion = chance(0.4, random) ? 0.2 : 0.0;
  problem.C = drawIntegers(rows, variables, 3, 0.6, random);
  for (int j = 1; j < rows; ++j)
    if (chance(0.15, random))
      problem.C.row(j) = problem.C.row(drawInteger(0, j - 1, random)) * drawInteger(-2, 2, random);
  for (int i = 0; i < variables; ++i)
    drawIntegerLimits(point(i), exclusion, random, problem.lower(i), problem.upper(i));
  for (int j = 0; j < rows; ++j)
    drawIntegerLimits(problem.C.row(j).dot(point), exclusion, random, problem.row_lower(j), problem.row_upper(j));
  return problem;
}

QpProblem makeFeasibleQp(int variables, int rows, std::mt19937& random) {
  QpProblem problem(variables, rows);
  const MatX factor = drawNormals(variables + 2, variables, random);
  problem.G = factor.transpose() * factor;
  problem.g = 5 * drawNormals(variables, 1, random);
  problem.C = drawNormals(rows, variables, random);
  const VecX point = drawNormals(variables, 1, random);
  const int flat = chance(0.3, random) ? drawInteger(0, variables, random) : 0;
  problem.G.topRows(flat).setZero();
  problem.G.leftCols(flat).setZero();
  const double share = drawReal(0.2, 0.9, random);
  for (int i = 0; i < variables; ++i)
    drawLimits(point(i), i < flat ? 1 : share, random, problem.lower(i), problem.upper(i));
  for (int j = 0; j < rows; ++j)
    drawLimits(problem.C.row(j).dot(point), share, random, problem.row_lower(j), problem.row_upper(j));
  return problem;
}

QpProblem makeInfeasibleQp(int variables, int rows, std::mt19937& random) {
  QpProblem problem = makeFeasibleQp(variables, rows, random);
  for (int i = 0; i < variables; ++i) {
    problem.lower(i) = std::max(problem.lower(i), -20.0);
    problem.upper(i) = std::min(problem.upper(i), 20.0);
  }
  // The last row is a negative combination of some others, and asks for more than they leave it.
  const int members = drawInteger(1, std::min(rows - 1, variables + 1), random);
  const int last = rows - 1;
  problem.C.row(last).setZero();
  double most = 0;
  for (int j = 0; j < members; ++j) {
    const double weight = drawReal(0.2, 1, random);
    if (!std::isfinite(problem.row_lower(j))) problem.row_lower(j) = problem.row_upper(j) - 1;
    if (!std::isfinite(problem.row_lower(j))) problem.row_lower(j) = 0;
    problem.C.row(last) -= weight * problem.C.row(j);
    most -= weight * problem.row_lower(j);
  }
  problem.row_lower(last) = most + drawReal(1e-3, 1, random);
  problem.row_upper(last) = kInfinity;
  return problem;
}

}  // namespace sinew
