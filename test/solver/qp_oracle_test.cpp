#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <iostream>
#include <limits>
#include <random>
#include <string>

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
  std::cout << "check=qp_oracle." << name << " value=" << value << " op=<= bound=" << bound << " unit=1\n";
  testing::Test::RecordProperty(name, std::to_string(value));
  EXPECT_LE(value, bound) << name;
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

/// Solves a neighbour of the problem first, so that the active set the solver starts from is near but not right.
void addWarmStart(const QpProblem& problem, const QpSolution& cold, std::mt19937& random, DenseQp& solver,
                  Worst& worst) {
  QpProblem neighbour = problem;
  std::normal_distribution<double> normal;
  for (int i = 0; i < problem.variables; ++i) neighbour.g(i) += 0.1 * normal(random);
  QpSolution warm(problem.variables, problem.rows);
  solver.solve(neighbour, warm);
  worst.status_mismatches += solver.solve(problem, warm) != cold.status;
  if (cold.status != QpStatus::kSolved) return;
  worst.warm_objective = std::max(worst.warm_objective, relativeDifference(warm.objective, cold.objective));
  worst.kkt = std::max(worst.kkt, kktError(problem, warm));
  worst.cold_iterations += cold.iterations;
  worst.warm_iterations += warm.iterations;
  if (isStrictlyConvex(problem))
    worst.warm_point = std::max(worst.warm_point, largest(warm.x - cold.x) / std::max(1.0, largest(cold.x)));
}

/// Mostly small, where degenerate cases abound and exact arithmetic is quick.
QpProblem drawProblem(int index, std::mt19937& random) {
  const bool large = index % 25 == 0;
  const int variables = std::uniform_int_distribution<int>(1, large ? 10 : 5)(random);
  const int rows = std::uniform_int_distribution<int>(0, large ? 40 : 12)(random);
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
    addWarmStart(problem, solution, random, solver, worst);
  }
  std::cout << worst.solved << " solved, " << worst.infeasible << " infeasible, " << worst.unbounded << " unbounded; "
            << worst.cold_iterations << " iterations cold, " << worst.warm_iterations << " warm\n";
  EXPECT_GT(worst.solved, kExactProblems / 3);
  EXPECT_GT(worst.infeasible, kExactProblems / 10);
  EXPECT_GT(worst.unbounded, kExactProblems / 50);
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
    addWarmStart(problem, solution, random, solver, worst);
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
