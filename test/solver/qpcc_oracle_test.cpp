#include "qpcc_oracle.h"

#include <gtest/gtest.h>

#include <random>

#include "check_line.h"
#include "random_qpcc.h"
#include "sinew/solver/qpcc_solver.h"

namespace sinew {
namespace {

constexpr int kProblems = 5000;

/// Every kind and size, with dependent and duplicate contacts, rates, rows held, and limits that exclude each other.
QpccProblem drawProblem(int number, std::mt19937& random) {
  const int na = 1 + static_cast<int>(random() % 6);
  const int nc = static_cast<int>(number % 2 == 0 ? random() % 11 : 6 + random() % 5);
  constexpr QpccKind kKinds[] = {QpccKind::kRandom, QpccKind::kLever, QpccKind::kBar, QpccKind::kLever};
  const QpccKind kind = kKinds[number % 4];
  QpccProblem problem = makeQpcc(kind, na, nc, random);
  const auto share = [&random] { return std::uniform_real_distribution<double>(0, 1)(random); };
  const int variant = number / 4 % 8;
  if (nc >= 2 && variant == 1) duplicateContact(0, 1, random() % 2 == 0 ? 0 : 1e-4, problem);
  if (nc >= 3 && variant == 2) averageContacts(0, 1, 2, problem);
  if (variant == 3) limitRates(problem.soft_upper * share(), 0.2, problem);
  if (variant == 4) holdRow(0, 0.8 * share(), problem);
  if (variant == 5) holdRow(0, 1.2 + share(), problem);
  if (variant == 6 && random() % 4 == 0) {
    limitRates(VecX::Zero(na), 1, problem);
    problem.row_lower(0) = problem.row_upper(0) = 100 * problem.row_upper(0);
  }
  return problem;
}

TEST(QpccOracle, agreesWithEnumeration) {
  std::mt19937 random(20);
  const QpccSizes capacity{6, 6, 3, 10};
  QpccSolver solver(capacity);
  QpccSolution solution(capacity);
  const QpccGuess none(capacity);
  QpccBudget budget;
  budget.max_pieces = 400;
  budget.max_nodes = 400;
  QpccTally tally;
  for (int number = 0; number < kProblems; ++number) {
    const QpccProblem problem = drawProblem(number, random);
    solver.solve(problem, none, budget, solution);
    tally.add(problem, solution, random);
  }
  tally.check("qpcc_oracle.");
  checkFigure("qpcc_oracle.problems", tally.problems(), ">=", 5000, "1");
  checkFigure("qpcc_oracle.solved", tally.solved(), ">=", 0.7 * kProblems, "1");
  checkFigure("qpcc_oracle.given_way", tally.givenWay(), ">=", 100, "1");
  checkFigure("qpcc_oracle.infeasible", tally.infeasible(), ">=", 20, "1");
  checkFigure("qpcc_oracle.decomposition_trapped", tally.calcTrapped(), ">=", 10, "%");
}

}  // namespace
}  // namespace sinew
