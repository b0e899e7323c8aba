#include "sinew/solver/dense_qp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "solver/allocation_count.h"
#include "solver/qp_check.h"
#include "solver/random_qp.h"

namespace sinew {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

QpSolution solveCold(const QpProblem& problem) {
  QpSolution solution(problem.variables, problem.rows);
  DenseQp(problem.variables, problem.rows).solve(problem, solution);
  return solution;
}

/// minimise (x - 3)^2 / 2 + (y + 1)^2 / 2
QpProblem makeDistance(int rows) {
  QpProblem problem(2, rows);
  problem.G.setIdentity();
  problem.g << -3, 1;
  return problem;
}

TEST(DenseQp, FindsTheFreeMinimum) {
  const QpSolution solution = solveCold(makeDistance(0));
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.x(0), 3, 1e-15);
  EXPECT_NEAR(solution.x(1), -1, 1e-15);
  EXPECT_NEAR(solution.objective, -5, 1e-14);
  EXPECT_EQ(solution.passes, 1);
}

TEST(DenseQp, ReportsBoundDualsWithTheirSigns) {
  QpProblem problem = makeDistance(0);
  problem.upper(0) = 1;
  problem.lower(1) = 0;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_EQ(solution.x(0), 1);
  EXPECT_EQ(solution.x(1), 0);
  EXPECT_NEAR(solution.bound_dual(0), -2, 1e-14);
  EXPECT_NEAR(solution.bound_dual(1), 1, 1e-14);
}

TEST(DenseQp, ProjectsOntoAnEquality) {
  QpProblem problem = makeDistance(1);
  problem.C << 1, 1;
  problem.row_lower(0) = problem.row_upper(0) = 4;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.x(0), 4, 1e-14);
  EXPECT_NEAR(solution.x(1), 0, 1e-14);
  EXPECT_NEAR(solution.row_dual(0), 1, 1e-14);
}

TEST(DenseQp, TakesEitherSideOfATwoSidedRow) {
  QpProblem problem = makeDistance(1);
  problem.C << 2, 0;
  problem.row_lower(0) = -1;
  problem.row_upper(0) = 4;
  EXPECT_NEAR(solveCold(problem).x(0), 2, 1e-14);
  EXPECT_NEAR(solveCold(problem).row_dual(0), -0.5, 1e-14);
  problem.g(0) = 3;
  EXPECT_NEAR(solveCold(problem).x(0), -0.5, 1e-14);
  EXPECT_NEAR(solveCold(problem).row_dual(0), 1.25, 1e-14);
}

TEST(DenseQp, AcceptsRepeatedEqualities) {
  QpProblem problem = makeDistance(3);
  problem.C << 1, 1, 2, 2, -1, -1;
  problem.row_lower << 4, 8, -4;
  problem.row_upper = problem.row_lower;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.x(0), 4, 1e-13);
  EXPECT_LE(kktError(problem, solution), 1e-13);
}

TEST(DenseQp, SolvesALinearProgram) {
  // maximise 3 x + 2 y; x + y <= 4, x + 3 y <= 6, 0 <= x <= 3, y >= 0: (3, 1)
  QpProblem problem(2, 2);
  problem.g << -3, -2;
  problem.lower.setZero();
  problem.upper(0) = 3;
  problem.C << 1, 1, 1, 3;
  problem.row_upper << 4, 6;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.x(0), 3, 1e-13);
  EXPECT_NEAR(solution.x(1), 1, 1e-13);
  EXPECT_NEAR(solution.objective, -11, 1e-12);
  EXPECT_LE(kktError(problem, solution), 1e-12);
}

TEST(DenseQp, SolvesASingularG) {
  // (x + y - 2)^2 / 2 with x <= 0.5: a line of minimisers
  QpProblem problem(2, 0);
  problem.G << 1, 1, 1, 1;
  problem.g << -2, -2;
  problem.upper(0) = 0.5;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.x.sum(), 2, 1e-11);
  EXPECT_NEAR(solution.objective, -2, 1e-12);
  EXPECT_LE(solution.x(0), 0.5);
}

TEST(DenseQp, SolvesAnEffectorErrorOfLowRank) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  QpProblem problem(8, 0);
  const MatX jacobian = MatX::NullaryExpr(3, 8, [&]() { return normal(random); });
  problem.G = jacobian.transpose() * jacobian;
  problem.g = -jacobian.transpose() * VecX::Constant(3, 0.1);
  problem.lower.setConstant(-1);
  problem.upper.setConstant(1);
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_LE(kktError(problem, solution), 1e-12);
  EXPECT_NEAR((jacobian * solution.x - VecX::Constant(3, 0.1)).norm(), 0, 1e-11);
}

TEST(DenseQp, ReportsTheDirectionAlongWhichItIsUnbounded) {
  QpProblem problem(3, 1);
  problem.G(0, 0) = 1;
  problem.g << 1, -1, -1;
  problem.C << 0, 1, 0;
  problem.row_upper(0) = 10;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kUnbounded);
  EXPECT_LE(directionError(problem, solution), 1e-9);
  EXPECT_NEAR(solution.x(2), 1, 1e-15);
}

TEST(DenseQp, FindsNothingUnboundedInAFarLimit) {
  QpProblem problem(2, 1);
  problem.g << -1, -1;
  problem.C << 1, 1;
  problem.row_upper(0) = 1e9;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.objective, -1e9, 1e-2);
  EXPECT_LE(solution.passes, 4);
}

TEST(DenseQp, ProvesInfeasibility) {
  // x >= 0, y >= 0, x + y <= -1
  QpProblem problem = makeDistance(1);
  problem.lower.setZero();
  problem.C << 1, 1;
  problem.row_upper(0) = -1;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kInfeasible);
  EXPECT_LE(certificateError(problem, solution), 1e-14);
  EXPECT_LT(solution.row_dual(0), 0);
  EXPECT_GT(solution.bound_dual.minCoeff(), 0);
}

TEST(DenseQp, ProvesThatEqualitiesContradict) {
  QpProblem problem = makeDistance(2);
  problem.C << 1, 1, 2, 2;
  problem.row_lower << 1, 3;
  problem.row_upper = problem.row_lower;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kInfeasible);
  EXPECT_LE(certificateError(problem, solution), 1e-14);
}

TEST(DenseQp, CallsCrossingLimitsInfeasible) {
  QpProblem problem = makeDistance(0);
  problem.lower(0) = 1;
  problem.upper(0) = 0;
  const QpSolution solution = solveCold(problem);
  EXPECT_EQ(solution.status, QpStatus::kInfeasible);
  EXPECT_EQ(solution.bound_dual, VecX::Zero(2));
}

TEST(DenseQp, ForgivesLimitsThatCrossByRounding) {
  QpProblem problem = makeDistance(0);
  problem.lower(0) = 1;
  problem.upper(0) = 1 - 1e-15;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.x(0), 1, 1e-14);
}

TEST(DenseQp, EndsAtADegenerateVertex) {
  // A cone over a regular polygon of 24 sides, all of which meet in the solution.
  constexpr int kSides = 24;
  QpProblem problem(3, kSides);
  problem.g << 0, 0, 1;
  for (int j = 0; j < kSides; ++j) {
    const double angle = 2 * M_PI * j / kSides;
    problem.C.row(j) << std::cos(angle), std::sin(angle), 1;
    problem.row_lower(j) = 1;
  }
  for (const double curvature : {0.0, 1.0}) {
    problem.G.setIdentity();
    problem.G *= curvature;
    const QpSolution solution = solveCold(problem);
    ASSERT_EQ(solution.status, QpStatus::kSolved);
    EXPECT_LE((solution.x - VecX::Unit(3, 2)).norm(), 1e-11);
    EXPECT_LE(kktError(problem, solution), 1e-11);
  }
}

TEST(DenseQp, EndsOnTheCyclingExampleOfBeale) {
  // Beale (1955), on which the plain simplex method cycles: optimum -1/20 at (1/25, 0, 1, 0).
  QpProblem problem(4, 3);
  problem.g << -0.75, 150, -0.02, 6;
  problem.lower.setZero();
  problem.C << 0.25, -60, -0.04, 9, 0.5, -90, -0.02, 3, 0, 0, 1, 0;
  problem.row_upper << 0, 0, 1;
  const QpSolution solution = solveCold(problem);
  ASSERT_EQ(solution.status, QpStatus::kSolved);
  EXPECT_NEAR(solution.objective, -0.05, 1e-12);
}

TEST(DenseQp, RefusesNumbersThatAreNone) {
  for (const double bad : {kNan, kInfinity}) {
    std::vector<QpProblem> problems(5, makeDistance(1));
    problems[0].G(0, 1) = problems[0].G(1, 0) = bad;
    problems[1].g(1) = bad;
    problems[2].C(0, 1) = bad;
    problems[3].lower(0) = bad;
    problems[4].row_upper(0) = -bad;
    for (const QpProblem& problem : problems) EXPECT_EQ(solveCold(problem).status, QpStatus::kNotFinite);
  }
}

TEST(DenseQp, DoesNotCallAnOverflowSolved) {
  QpProblem problem = makeDistance(0);
  problem.G *= 1e-200;
  problem.g *= 1e200;
  EXPECT_EQ(solveCold(problem).status, QpStatus::kIterationLimit);
}

TEST(DenseQp, StopsAtTheIterationLimit) {
  std::mt19937 random(3);
  const QpProblem problem = makeFeasibleQp(10, 40, random);
  QpSolution solution(10, 40);
  DenseQpSettings settings;
  settings.max_iterations = 1;
  EXPECT_EQ(DenseQp(10, 40, settings).solve(problem, solution), QpStatus::kIterationLimit);
  settings.max_iterations = 1000;
  EXPECT_EQ(DenseQp(10, 40, settings).solve(problem, solution), QpStatus::kSolved);
}

TEST(DenseQp, StartsFromItsLastActiveSetUntilItForgets) {
  std::mt19937 random(11);
  QpProblem problem = makeFeasibleQp(10, 40, random);
  DenseQp solver(10, 40);
  QpSolution cold(10, 40);
  QpSolution warm(10, 40);
  ASSERT_EQ(solver.solve(problem, cold), QpStatus::kSolved);
  ASSERT_GT(cold.iterations, 3);
  ASSERT_EQ(solver.solve(problem, warm), QpStatus::kSolved);
  EXPECT_EQ(warm.iterations, 0);
  EXPECT_LE(largest(warm.x - cold.x), 1e-12);
  solver.forget();
  ASSERT_EQ(solver.solve(problem, warm), QpStatus::kSolved);
  EXPECT_EQ(warm.iterations, cold.iterations);
  EXPECT_EQ(warm.x, cold.x);
}

TEST(DenseQp, ServesProblemsOfChangingSize) {
  std::mt19937 random(5);
  DenseQp solver(8, 20);
  QpProblem roomy(8, 20);
  QpSolution solution(8, 20);
  for (int round = 0; round < 50; ++round) {
    const int n = 1 + round % 8;
    const int m = (7 * round) % 21;
    const QpProblem problem = makeFeasibleQp(n, m, random);
    roomy.resize(n, m);
    roomy.G.topLeftCorner(n, n) = problem.G;
    roomy.g.head(n) = problem.g;
    roomy.lower.head(n) = problem.lower;
    roomy.upper.head(n) = problem.upper;
    roomy.C.topLeftCorner(m, n) = problem.C;
    roomy.row_lower.head(m) = problem.row_lower;
    roomy.row_upper.head(m) = problem.row_upper;
    ASSERT_EQ(solver.solve(roomy, solution), QpStatus::kSolved);
    EXPECT_LE(relativeDifference(solution.objective, solveCold(problem).objective), 1e-11);
  }
}

TEST(DenseQp, SolvesAProblemWithoutUnknownsOrRows) {
  EXPECT_EQ(solveCold(QpProblem(0, 0)).status, QpStatus::kSolved);
  QpProblem impossible(0, 1);
  impossible.row_lower(0) = 1;
  EXPECT_EQ(solveCold(impossible).status, QpStatus::kInfeasible);
}

/// The same problem in other units: x = unit * x', every row times its own factor, the objective times its own.
QpProblem inUnits(const QpProblem& problem, const VecX& unit, const VecX& row_unit, double objective_unit) {
  QpProblem other = problem;
  other.G = objective_unit * unit.asDiagonal() * problem.G * unit.asDiagonal();
  other.g = objective_unit * problem.g.cwiseProduct(unit);
  other.lower = problem.lower.cwiseQuotient(unit);
  other.upper = problem.upper.cwiseQuotient(unit);
  other.C = row_unit.asDiagonal() * problem.C * unit.asDiagonal();
  other.row_lower = problem.row_lower.cwiseProduct(row_unit);
  other.row_upper = problem.row_upper.cwiseProduct(row_unit);
  return other;
}

TEST(DenseQp, GivesTheSameAnswerInAnyUnits) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const int n = 1 + static_cast<int>(seed % 10);
    const int m = static_cast<int>(seed % 30);
    const QpProblem problem = seed % 4 == 3 && m >= 2 ? makeInfeasibleQp(n, m, random) : makeFeasibleQp(n, m, random);
    std::uniform_real_distribution<double> exponent(-6, 6);
    const VecX unit = VecX::NullaryExpr(n, [&]() { return std::pow(10.0, exponent(random)); });
    const VecX row_unit = VecX::NullaryExpr(m, [&]() { return std::pow(10.0, exponent(random)); });
    const double objective_unit = std::pow(10.0, exponent(random));

    const QpSolution reference = solveCold(problem);
    QpSolution solution = solveCold(inUnits(problem, unit, row_unit, objective_unit));
    ASSERT_EQ(solution.status, reference.status) << "seed " << seed;
    const double dual_unit = solution.status == QpStatus::kSolved ? objective_unit : 1;
    solution.x = solution.x.cwiseProduct(unit);
    solution.bound_dual = solution.bound_dual.cwiseQuotient(unit) / dual_unit;
    solution.row_dual = solution.row_dual.cwiseProduct(row_unit) / dual_unit;
    if (solution.status == QpStatus::kInfeasible) {
      EXPECT_LE(certificateError(problem, solution), 1e-9) << "seed " << seed;
    } else {
      EXPECT_LE(kktError(problem, solution), 1e-9) << "seed " << seed;
      EXPECT_LE(relativeDifference(solution.objective / objective_unit, reference.objective), 1e-9) << "seed " << seed;
    }
  }
}

TEST(DenseQp, KeepsTheBoundsToTheLastBit) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const QpProblem problem = makeFeasibleQp(8, 20, random);
    const QpSolution solution = solveCold(problem);
    ASSERT_EQ(solution.status, QpStatus::kSolved);
    EXPECT_TRUE((solution.x.array() >= problem.lower.array()).all()) << "seed " << seed;
    EXPECT_TRUE((solution.x.array() <= problem.upper.array()).all()) << "seed " << seed;
  }
}

TEST(DenseQp, NeverAllocatesInASolve) {
  if (!countsAllocations()) GTEST_SKIP() << "allocations are not counted in this build";
  std::mt19937 random(9);
  std::vector<QpProblem> problems;
  for (int round = 0; round < 60; ++round) {
    const int n = 1 + round % 30;
    const int m = 2 + (11 * round) % 90;
    problems.push_back(round % 3 == 0   ? makeIntegerQp(n, m, random)
                       : round % 3 == 1 ? makeFeasibleQp(n, m, random)
                                        : makeInfeasibleQp(n, m, random));
  }
  problems.push_back(makeFeasibleQp(64, 256, random));
  DenseQp solver(64, 256);
  QpSolution solution(64, 256);

  const long before_check = allocationCount();
  VecX probe(3);
  ASSERT_GT(allocationCount(), before_check) << "the counter does not count";

  const long before = allocationCount();
  for (const QpProblem& problem : problems) {
    solver.solve(problem, solution);
    solver.solve(problem, solution);
  }
  EXPECT_EQ(allocationCount(), before);
}

}  // namespace
}  // namespace sinew
