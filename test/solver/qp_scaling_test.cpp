#include "sinew/solver/qp_scaling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace sinew {
namespace {

bool isPowerOfTwo(double value) {
  int exponent = 0;
  return value > 0 && std::frexp(value, &exponent) == 0.5;
}

/// Compliances of four actuators in N or Pa: entries between 1e-24 and 1e-4.
QpProblem makeMixedUnits() {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  MatX jacobian = MatX::NullaryExpr(6, 4, [&]() { return normal(random); });
  QpProblem problem(4, 3);
  problem.C = MatX::NullaryExpr(3, 4, [&]() { return normal(random); });
  const Vec4 unit(1e-2, 1e-3, 1e-9, 1e-12);
  problem.G = unit.asDiagonal() * jacobian.transpose() * jacobian * unit.asDiagonal();
  problem.C = Vec3(1e-5, 1, 1e4).asDiagonal() * problem.C * unit.asDiagonal();
  problem.g = unit;
  problem.lower.setConstant(-2);
  return problem;
}

TEST(QpScaling, BringsMixedUnitsNearOne) {
  const QpProblem problem = makeMixedUnits();
  QpScaling scaling(4, 3);
  ScaledQp scaled(4, 3);
  updateScaling(problem, scaling);
  scaleProblem(problem, scaling, scaled);
  EXPECT_GT(scaled.G.diagonal().minCoeff(), 0.02);
  EXPECT_LT(scaled.G.diagonal().maxCoeff(), 4);
  EXPECT_GT(scaled.normals.cwiseAbs().colwise().maxCoeff().minCoeff(), 0.4);
  EXPECT_LT(scaled.normals.cwiseAbs().maxCoeff(), 2.5);
}

TEST(QpScaling, RoundsNothing) {
  const QpProblem problem = makeMixedUnits();
  QpScaling scaling(4, 3);
  ScaledQp scaled(4, 3);
  updateScaling(problem, scaling);
  scaleProblem(problem, scaling, scaled);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(isPowerOfTwo(scaling.unknown(i)));
  for (int j = 0; j < 3; ++j) EXPECT_TRUE(isPowerOfTwo(scaling.row(j)));
  EXPECT_TRUE(isPowerOfTwo(scaling.objective));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(scaled.g(i) / (scaling.unknown(i) * scaling.objective), problem.g(i));
    EXPECT_EQ(scaled.lower(i) * scaling.unknown(i), problem.lower(i));
    EXPECT_TRUE(std::isinf(scaled.upper(i)));
    for (int j = 0; j < 3; ++j)
      EXPECT_EQ(scaled.normals(i, j) / (scaling.unknown(i) * scaling.row(j)), problem.C(j, i));
  }
}

TEST(QpScaling, MeetsDisagreementHalfway) {
  QpProblem problem(2, 1);
  problem.G.diagonal() << 1, 1e-16;  // the objective asks for units 1 : 1e8, the row for 1 : 1
  problem.C << 1, 1;
  QpScaling scaling(2, 1);
  updateScaling(problem, scaling);
  const double ratio = scaling.unknown(1) / scaling.unknown(0);
  EXPECT_GT(ratio, 1e3);
  EXPECT_LT(ratio, 1e5);
}

TEST(QpScaling, LeavesAnEmptyProblemAlone) {
  QpScaling scaling(2, 2);
  updateScaling(QpProblem(2, 2), scaling);
  EXPECT_EQ(scaling.unknown, VecX::Ones(2));
  EXPECT_EQ(scaling.row, VecX::Ones(2));
  EXPECT_EQ(scaling.objective, 1);
}

}  // namespace
}  // namespace sinew
