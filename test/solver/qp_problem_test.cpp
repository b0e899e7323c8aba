#include "sinew/solver/qp_problem.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew {
namespace {

TEST(QpProblem, StartsWithoutObjectiveOrLimits) {
  const QpProblem problem(3, 2);
  EXPECT_EQ(problem.variables, 3);
  EXPECT_EQ(problem.rows, 2);
  EXPECT_TRUE(problem.G.isZero(0) && problem.g.isZero(0) && problem.C.isZero(0));
  EXPECT_EQ(problem.lower.maxCoeff(), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(problem.row_upper.minCoeff(), std::numeric_limits<double>::infinity());
}

TEST(QpProblem, ResizesWithinItsMemory) {
  QpProblem problem(3, 2);
  problem.G(0, 0) = 7;
  const double* memory = problem.G.data();
  problem.resize(1, 0);
  EXPECT_EQ(problem.variables, 1);
  EXPECT_EQ(problem.rows, 0);
  EXPECT_EQ(problem.G.data(), memory);
  EXPECT_EQ(problem.G(0, 0), 7);
}

}  // namespace
}  // namespace sinew
