#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <iostream>
#include <limits>
#include <random>
#include <string>

#include "check_line.h"
#include "sinew/solver/dense_qp.h"
#include "solver/exact_qp.h"
#include "solver/qp_check.h"
#include "solver/random_qp.h"

namespace sinew {
namespace {

constexpr int kExactProblems = 10000;
constexpr int kLargeProblems = 150;
constexpr double kBound = 1e-9;

/// Records a worst figure for the test report and for scripts, and holds it against its bound.
void expectAtMost(const std::string& name, double value, double bound) {
  testing::Test::RecordProperty(name, std::to_string(value));
  checkFigure("qp_oracle." + name, value, "<=", bound, "1");
}

struct Worst {
  int status_mismatches = 0;
  double objective = 0, kkt = 0, certificate = 0, direction = 0, warm_objective = 0, warm_point = 0;
  int solved = 0, infeasible = 0, unbounded = 0;
  long cold_iterations = 0, warm_iterations = 0;
};

void addProof(const QpProblem& problem, const QpSolution& solution, Worst& worst) {
  switch (solution.status) {
    case QpStatus::kSolved:
      ++worst.solved;
      worst.kkt = std::max(worst.kkt, kktError(problem, solution));
      break;
    case QpStatus::kInfeasible:
      ++worst.infeasible;
      worst.certificate = std::max(worst.certificate, certificateError(problem, solution));
      break;
    case QpStatus::kUnbounded:
      ++worst.unbounded;
      worst.direction = std::max(worst.direction, directionError(problem, solution));
      break;
    default:
      break;
  }
}

bool isStrictlyConvex(const QpProblem& problem) {
  return Eigen::SelfAdjointEigenSolver<MatX>(problem.G).eigenvalues().minCoeff() > 1e-3;
}

/// The problem with a slope a little off, so that its active set is near the right one.
QpProblem makeNeighbour(const QpProblem& problem, std::mt19937& random) {
  QpProblem neighbour = problem;
  std::normal_distribution<double> normal;
  for (int i = 0; i < problem.variables; ++i) neighbour.g(i) += 0.1 * normal(random);
  return neighbour;
}

/// Solves `problem` from the active set of `first`.
QpSolution addWarmStart(const QpProblem& first, const QpProblem& problem, const QpSolution& cold, Worst& worst) {
  DenseQp solver(problem.variables, problem.rows);
  QpSolution warm(problem.variables, problem.rows);
  solver.solve(first, warm);
  worst.status_mismatches += solver.solve(problem, warm) != cold.status;
  if (cold.status != QpStatus::kSolved) return warm;
  worst.warm_objective = std::max(worst.warm_objective, relativeDifference(warm.objective, cold.objective));
  worst.kkt = std::max(worst.kkt, kktError(problem, warm));
  if (isStrictlyConvex(problem))
    worst.warm_point = std::max(worst.warm_point, largest(warm.x - cold.x) / std::max(1.0, largest(cold.x)));
  return warm;
}

/// From a near active set, which saves iterations, and from that of a stranger, which may not hurt.
void addWarmStarts(const QpProblem& problem, const QpSolution& cold, std::mt19937& random, Worst& worst) {
  const QpSolution warm = addWarmStart(makeNeighbour(problem, random), problem, cold, worst);
  if (cold.status == QpStatus::kSolved) {
    worst.cold_iterations += cold.iterations;
    worst.warm_iterations += warm.iterations;
  }
  addWarmStart(makeFeasibleQp(problem.variables, problem.rows, random), problem, cold, worst);
}

/// Mostly small, where degenerate cases abound and exact arithmetic is quick.
QpProblem drawProblem(int index, std::mt19937& random) {
  const bool large = index / 5 % 5 == 0;
  const int variables = std::uniform_int_distribution<int>(1, large ? 10 : 6)(random);
  const int rows = std::uniform_int_distribution<int>(0, large ? 40 : 24)(random);
  switch (index % 5) {
    case 0:
    case 1:
    case 2:
      return makeIntegerQp(variables, rows, random);
    case 3:
      return makeFeasibleQp(variables, rows, random);
    default:
      return makeInfeasibleQp(variables, std::max(rows, 2), random);
  }
}

std::string describe(const QpProblem& problem, int index) {
  return "problem " + std::to_string(index) + " with " + std::to_string(problem.variables) + " unknowns and " +
         std::to_string(problem.rows) + " rows";
}

TEST(QpOracle, AgreesWithExactArithmetic) {
  Worst worst;
  for (int index = 0; index < kExactProblems; ++index) {
    std::mt19937 random(static_cast<unsigned>(index));
    const QpProblem problem = drawProblem(index, random);
    DenseQp solver(problem.variables, problem.rows);
    QpSolution solution(problem.variables, problem.rows);
    solver.solve(problem, solution);

    const ExactAnswer exact = solveExactly(problem);
    EXPECT_EQ(static_cast<int>(solution.status), static_cast<int>(exact.status)) << describe(problem, index);
    worst.status_mismatches += solution.status != exact.status;
    if (solution.status == QpStatus::kSolved && exact.status == QpStatus::kSolved) {
      const double error = relativeDifference(solution.objective, exact.objective);
      EXPECT_LE(error, kBound) << describe(problem, index);
      worst.objective = std::max(worst.objective, error);
    }
    addProof(problem, solution, worst);
    addWarmStarts(problem, solution, random, worst);
  }
  std::cout << worst.solved << " solved, " << worst.infeasible << " infeasible, " << worst.unbounded << " unbounded; "
            << worst.cold_iterations << " iterations cold, " << worst.warm_iterations << " warm\n";
  EXPECT_GT(worst.solved, kExactProblems / 3);
  EXPECT_GT(worst.infeasible, kExactProblems / 10);
  EXPECT_GT(worst.unbounded, kExactProblems / 100);
  EXPECT_LT(worst.warm_iterations, worst.cold_iterations / 2);
  expectAtMost("status_mismatches", worst.status_mismatches, 0);
  expectAtMost("objective", worst.objective, kBound);
  expectAtMost("kkt", worst.kkt, kBound);
  expectAtMost("certificate", worst.certificate, kBound);
  expectAtMost("direction", worst.direction, kBound);
  expectAtMost("warm_objective", worst.warm_objective, kBound);
  expectAtMost("warm_point", worst.warm_point, kBound);
}

TEST(QpOracle, LargeProblemsProveThemselves) {
  Worst worst;
  for (int index = 0; index < kLargeProblems; ++index) {
    std::mt19937 random(static_cast<unsigned>(1000000 + index));
    const int variables = std::uniform_int_distribution<int>(20, 64)(random);
    const int rows = std::uniform_int_distribution<int>(variables, 256)(random);
    const bool feasible = index % 3 != 0;
    const QpProblem problem =
        feasible ? makeFeasibleQp(variables, rows, random) : makeInfeasibleQp(variables, rows, random);
    DenseQp solver(variables, rows);
    QpSolution solution(variables, rows);
    solver.solve(problem, solution);
    const QpStatus expected = feasible ? QpStatus::kSolved : QpStatus::kInfeasible;
    EXPECT_EQ(static_cast<int>(solution.status), static_cast<int>(expected)) << describe(problem, index);
    worst.status_mismatches += solution.status != expected;
    addProof(problem, solution, worst);
    addWarmStarts(problem, solution, random, worst);
  }
  std::cout << worst.cold_iterations << " iterations cold, " << worst.warm_iterations << " warm\n";
  expectAtMost("large_status_mismatches", worst.status_mismatches, 0);
  expectAtMost("large_kkt", worst.kkt, kBound);
  expectAtMost("large_certificate", worst.certificate, kBound);
  expectAtMost("large_warm_objective", worst.warm_objective, kBound);
  expectAtMost("large_warm_point", worst.warm_point, kBound);
}

}  // namespace
}  // namespace sinew
