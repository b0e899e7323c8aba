#include "sinew/solver/qpcc_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "allocation_count.h"
#include "qpcc_enumeration.h"
#include "random_qpcc.h"

namespace sinew {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One actuator that pushes a point along, x in metres. An obstacle stands `gap` ahead; what it presses tilts the
/// effector forward by `lever` times the force, so that targets beyond it are reached only through contact.
QpccProblem makeLever(double target) {
  QpccProblem problem({1, 1, 1, 1});
  problem.E_a << 0.2;
  problem.E_c << 1;
  problem.e << -target;
  problem.Q << 1e-6;
  problem.A_a << 1;
  problem.C_a << -1;
  problem.C_c << 1;
  problem.c << 1;
  problem.x_lower << -3;
  problem.x_upper << 3;
  return problem;
}

/// The same between two obstacles: pressing either one moves the effector far to its side, so that x < 0 and x > 0
/// each have an optimum of their own.
QpccProblem makeTwoSides(double left, double right) {
  QpccProblem problem({1, 1, 2, 2});
  problem.E_a << 0, 0;
  problem.E_c << 1, 0, 0, 1;
  problem.e << -left, -right;
  problem.Q << 1e-6;
  problem.A_a << 2;
  problem.C_a << -1, 1;
  problem.C_c << 1, 0, 0, 1;
  problem.c << 0, 0;
  problem.x_lower << -3;
  problem.x_upper << 3;
  return problem;
}

QpccSolution solve(const QpccProblem& problem, const QpccGuess& guess, const QpccBudget& budget = QpccBudget()) {
  QpccSolver solver(problem.size);
  QpccSolution solution(problem.size);
  EXPECT_EQ(solver.solve(problem, guess, budget, solution), solution.status);
  return solution;
}

QpccSolution solve(const QpccProblem& problem) {
  return solve(problem, QpccGuess(problem.size));
}

TEST(QpccSolver, reachesThroughContact) {
  const QpccSolution solution = solve(makeLever(1.2));
  ASSERT_EQ(solution.status, QpccStatus::kSolved);
  EXPECT_NEAR(0.2 * solution.x(0) + solution.z(0), 1.2, 1e-5);
  EXPECT_NEAR(solution.z(0), solution.x(0) - 1, 1e-12);
  EXPECT_EQ(solution.g(0), 0);
  EXPECT_EQ(solution.active[0], 1);
  EXPECT_TRUE(solution.proved_global);
}

TEST(QpccSolver, staysAwayFromContactWhereThatIsBest) {
  const QpccSolution solution = solve(makeLever(0.1));
  ASSERT_EQ(solution.status, QpccStatus::kSolved);
  EXPECT_NEAR(solution.x(0), 0.5, 1e-4);
  EXPECT_EQ(solution.z(0), 0);
  EXPECT_NEAR(solution.g(0), 1 - solution.x(0), 1e-12);
}

TEST(QpccSolver, leavesALocalOptimum) {
  const QpccProblem problem = makeTwoSides(1, 1.5);
  QpccGuess guess(problem.size);
  guess.valid = true;
  guess.x << 1;
  guess.active = {1, 0};
  const QpccSolution solution = solve(problem, guess);
  ASSERT_EQ(solution.status, QpccStatus::kSolved);
  EXPECT_NEAR(solution.decomposition_objective, 0.5 * 1.5 * 1.5, 1e-4);
  EXPECT_NEAR(solution.objective, 0.5, 1e-4);
  EXPECT_NEAR(solution.x(0), -1.5, 1e-4);
  EXPECT_TRUE(solution.proved_global);
  EXPECT_FALSE(solution.declined_better);
}

TEST(QpccSolver, declinesWhatIsTooLittleBetter) {
  const QpccProblem problem = makeTwoSides(1, 1.05);
  QpccGuess guess(problem.size);
  guess.valid = true;
  guess.x << 1;
  guess.active = {1, 0};
  guess.margin = 0.034;  // gain (1.05^2 - 1) / 2, error 1.05, way |(1, 1.05)|: 0.0337
  const QpccSolution solution = solve(problem, guess);
  EXPECT_NEAR(solution.x(0), 1, 1e-4);
  EXPECT_TRUE(solution.declined_better);
  EXPECT_NEAR(solution.declined_objective, 0.5, 1e-4);
  EXPECT_FALSE(solution.proved_global);
  guess.margin = 0.033;
  EXPECT_NEAR(solve(problem, guess).x(0), -1.05, 1e-4);
}

TEST(QpccSolver, takesTheMarginOfTheWholeObjective) {
  const QpccProblem problem = makeTwoSides(1, 1.05);
  QpccGuess guess(problem.size);
  guess.valid = true;
  guess.x << 1;
  guess.active = {1, 0};
  guess.margin = 0.033;
  guess.offset = 1;  // a larger residual to take the share of
  EXPECT_NEAR(solve(problem, guess).x(0), 1, 1e-4);
  guess.offset = -0.5;
  EXPECT_NEAR(solve(problem, guess).x(0), -1.05, 1e-4);
}

TEST(QpccSolver, declinesWhatIsTooFar) {
  const QpccProblem problem = makeTwoSides(1, 1.5);
  QpccGuess guess(problem.size);
  guess.valid = true;
  guess.x << 1;
  guess.active = {1, 0};
  guess.row << 2;  // the other answer is at -3  // the other answer is at -3
  guess.reach << 4.9;
  const QpccSolution solution = solve(problem, guess);
  EXPECT_NEAR(solution.x(0), 1, 1e-4);
  EXPECT_TRUE(solution.declined_better);
  guess.reach << 5.1;
  EXPECT_NEAR(solve(problem, guess).x(0), -1.5, 1e-4);
}

TEST(QpccSolver, letsSoftLimitsGiveWay) {
  QpccProblem problem = makeLever(1);
  problem.soft_lower << 0;
  problem.soft_upper << 1;
  problem.row_lower << 1.5;
  problem.row_upper << 2;
  QpccSolution solution = solve(problem);
  ASSERT_EQ(solution.status, QpccStatus::kGivenWay);
  EXPECT_NEAR(solution.x(0), 1.5, 1e-6);
  EXPECT_NEAR(solution.soft_violation(0), 0.5, 1e-6);
  EXPECT_EQ(solution.row_violation, 0);

  problem.x_upper << 1.2;
  solution = solve(problem);
  ASSERT_EQ(solution.status, QpccStatus::kInfeasible);
  EXPECT_NEAR(solution.x(0), 1.2, 1e-6);
  EXPECT_LE(solution.x(0), 1.2);
  EXPECT_NEAR(solution.row_violation, 0.3, 1e-6);
}

TEST(QpccSolver, refusesWhatIsNotFinite) {
  QpccProblem problem = makeLever(1);
  problem.C_c(0, 0) = std::nan("");
  EXPECT_EQ(solve(problem).status, QpccStatus::kNotFinite);
  problem = makeLever(1);
  problem.x_lower(0) = kInfinity;
  EXPECT_EQ(solve(problem).status, QpccStatus::kNotFinite);
}

TEST(QpccSolver, survivesContactsWithoutCompliance) {
  // A rigid part: the gap depends on x alone, and no force changes it.
  QpccProblem problem = makeLever(3);
  problem.C_c << 0;
  problem.E_c << 0;
  const QpccSolution solution = solve(problem);
  ASSERT_EQ(solution.status, QpccStatus::kSolved);
  EXPECT_NEAR(solution.x(0), 1, 1e-6);
}

TEST(QpccSolver, takesEmptyProblems) {
  EXPECT_EQ(solve(QpccProblem({0, 0, 0, 0})).status, QpccStatus::kSolved);
  QpccProblem contact_only({0, 0, 1, 1});
  contact_only.E_c << 1;
  contact_only.C_c << 2;
  contact_only.c << -1;
  const QpccSolution solution = solve(contact_only);
  ASSERT_EQ(solution.status, QpccStatus::kSolved);
  EXPECT_NEAR(solution.z(0), 0.5, 1e-12);
}

TEST(QpccSolver, keepsItsDeadline) {
  std::mt19937 random(1);
  const QpccProblem problem = makeQpcc(QpccKind::kRandom, 8, 76, random);
  QpccBudget budget;
  budget.deadline = std::chrono::steady_clock::now();
  const QpccSolution solution = solve(problem, QpccGuess(problem.size), budget);
  EXPECT_TRUE(solution.deadline_ended);
  EXPECT_FALSE(solution.proved_global);
  EXPECT_EQ(solution.nodes, 0);
  EXPECT_NE(solution.status, QpccStatus::kFailed);
}

TEST(QpccSolver, isRepeatable) {
  std::mt19937 random(2);
  const QpccSizes size{4, 4, 3, 20};
  QpccSolver first(size), second(size);
  QpccSolution a(size), b(size);
  const QpccGuess none(size);
  for (int k = 0; k < 20; ++k) {
    const QpccProblem problem = makeQpcc(QpccKind::kLever, 4, 20, random);
    first.solve(problem, none, QpccBudget(), a);
    second.solve(problem, none, QpccBudget(), b);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.pieces, b.pieces);
    EXPECT_EQ(a.nodes, b.nodes);
  }
}

TEST(QpccSolver, neverAllocates) {
  std::mt19937 random(3);
  const QpccSizes capacity{8, 8, 3, 76};
  QpccSolver solver(capacity);
  QpccSolution solution(capacity);
  QpccGuess guess(capacity);
  std::vector<QpccProblem> problems;
  for (int k = 0; k < 12; ++k) {
    const int unknowns = 1 + static_cast<int>(random() % 8);
    const int contacts = k == 0 ? 76 : static_cast<int>(random() % 40);
    problems.push_back(makeQpcc(static_cast<QpccKind>(k % 3), unknowns, contacts, random));
    if (k % 4 == 3) holdRow(0, 1.5, problems.back());
  }
  QpccBudget budget;
  budget.max_nodes = 30;
  const long before = allocationCount();
  for (const QpccProblem& problem : problems) {
    guess.valid = false;
    for (int repeat = 0; repeat < 2; ++repeat) {
      solver.solve(problem, guess, budget, solution);
      guess.valid = true;
      guess.x = solution.x;
      guess.active = solution.active;
    }
  }
  EXPECT_EQ(allocationCount(), before);
}

}  // namespace
}  // namespace sinew
