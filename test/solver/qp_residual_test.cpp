#include "sinew/solver/qp_residual.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew {
namespace {

/// minimise (x - 3)^2 / 2 + (y + 1)^2 / 2 with x <= 1, x + y >= 1: x = (1, 0), duals -3 and 1 by hand
class QpResidualTest : public testing::Test {
 protected:
  QpResidualTest() {
    problem_.G.setIdentity();
    problem_.g << -3, 1;
    problem_.upper(0) = 1;
    problem_.C << 1, 1;
    problem_.row_lower(0) = 1;
    solution_.x << 1, 0;
    solution_.bound_dual << -3, 0;
    solution_.row_dual << 1;
    updateScaling(problem_, scaling_);
  }

  KktResidual calc() const { return calcKktResidual(problem_, scaling_, solution_); }

  QpProblem problem_{2, 1};
  QpScaling scaling_{2, 1};
  QpSolution solution_{2, 1};
};

TEST_F(QpResidualTest, VanishesAtTheSolution) {
  EXPECT_EQ(calc().worst(), 0);
}

TEST_F(QpResidualTest, SeesAWrongDual) {
  solution_.row_dual(0) += 0.07;  // the terms of the first unknown sum to 1 + 3 + 3 + 1.07
  EXPECT_NEAR(calc().stationarity, 0.07 / 8.07, 1e-12);
  EXPECT_EQ(calc().feasibility, 0);
}

TEST_F(QpResidualTest, SeesAMissedLimit) {
  solution_.x(0) = 1.3;  // |g| is the larger magnitude
  EXPECT_NEAR(calc().feasibility, 0.1, 1e-12);
  problem_.row_lower(0) = 1.9;
  EXPECT_NEAR(calc().feasibility, 0.2, 1e-12);
}

TEST_F(QpResidualTest, SeesADualAwayFromItsLimit) {
  solution_.x(1) = 0.3;
  EXPECT_NEAR(calc().complementarity, 0.1, 1e-12);
}

TEST_F(QpResidualTest, SeesADualWithoutALimit) {
  solution_.bound_dual(0) = 3;
  EXPECT_NEAR(calc().complementarity, 3.0 / 8.0, 1e-12);
}

TEST_F(QpResidualTest, IsInfiniteForASolutionThatIsNotFinite) {
  solution_.x(0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isinf(calc().worst()));
}

TEST_F(QpResidualTest, AcceptsAProofOfInfeasibility) {
  problem_.upper << 1, 1;  // x + y >= 3 asks for more than 2
  problem_.row_lower(0) = 3;
  solution_.bound_dual << -1, -1;
  solution_.row_dual << 1;
  const InfeasibilityProof proof = calcInfeasibilityProof(problem_, scaling_, solution_);
  EXPECT_EQ(proof.imbalance, 0);
  EXPECT_NEAR(proof.gap, 1.0 / 5.0, 1e-15);
  EXPECT_TRUE(proof.holds(1e-9));
}

TEST_F(QpResidualTest, RejectsAFalseProofOfInfeasibility) {
  problem_.upper << 1, 1;
  solution_.bound_dual << -1, -1;
  solution_.row_dual << 1;
  problem_.row_lower(0) = 2;  // just reached
  EXPECT_FALSE(calcInfeasibilityProof(problem_, scaling_, solution_).holds(1e-9));
  problem_.row_lower(0) = 3;
  solution_.bound_dual(1) = -0.9;  // does not balance
  EXPECT_FALSE(calcInfeasibilityProof(problem_, scaling_, solution_).holds(1e-9));
  solution_.bound_dual << -1, -1;
  solution_.row_dual << -1;  // names an infinite limit
  EXPECT_FALSE(calcInfeasibilityProof(problem_, scaling_, solution_).holds(1e-9));
}

TEST_F(QpResidualTest, TakesCrossingLimitsForAProof) {
  problem_.lower(1) = 2;
  problem_.upper(1) = 1;
  EXPECT_TRUE(hasCrossingLimits(problem_));
  EXPECT_TRUE(calcInfeasibilityProof(problem_, scaling_, QpSolution(2, 1)).holds(1e-9));
  problem_.upper(1) = 2 - 1e-15;
  EXPECT_FALSE(hasCrossingLimits(problem_));
}

}  // namespace
}  // namespace sinew
