#include "sinew/solver/qpcc_relaxation.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "qpcc_enumeration.h"
#include "random_qpcc.h"

namespace sinew {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Hessian of f + rho z^T g in (z, x).
MatX calcHessian(const ScaledQpcc& s, double rho) {
  const int nc = s.size.contacts;
  const int n = nc + s.size.unknowns;
  const MatX E = s.table.block(s.limitedRows(), 0, s.size.effectors, n);
  MatX H = E.transpose() * E;
  H.bottomRightCorner(s.size.unknowns, s.size.unknowns) += s.Q;
  H.topRows(nc) += rho * s.table.topLeftCorner(nc, n);
  H.leftCols(nc) += rho * s.table.topLeftCorner(nc, n).transpose();
  return H;
}

double calcLeastEigenvalue(const MatX& H) {
  return Eigen::SelfAdjointEigenSolver<MatX>(H, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

TEST(QpccRelaxation, takesTheLargestConvexRho) {
  std::mt19937 random(1);
  for (int k = 0; k < 60; ++k) {
    const QpccProblem problem = makeQpcc(static_cast<QpccKind>(k % 3), 3, 8, random);
    ScaledQpcc scaled(problem.size);
    scaled.update(problem);
    QpccRelaxation relaxation(problem.size);
    ASSERT_TRUE(relaxation.prepare(scaled)) << k;
    EXPECT_GT(calcLeastEigenvalue(calcHessian(scaled, relaxation.rho())), -1e-7) << k;
    EXPECT_LT(calcLeastEigenvalue(calcHessian(scaled, 1.2 * relaxation.rho())), 0) << k;
  }
}

TEST(QpccRelaxation, boundsTheOptimum) {
  std::mt19937 random(2);
  double tightest = 0;
  for (int k = 0; k < 150; ++k) {
    const QpccProblem problem = makeQpcc(static_cast<QpccKind>(k % 3), 3, 6, random);
    const double optimum = FullQpcc(problem).enumerate();
    if (!std::isfinite(optimum)) continue;
    ScaledQpcc scaled(problem.size);
    scaled.update(problem);
    QpccRelaxation relaxation(problem.size);
    ASSERT_TRUE(relaxation.prepare(scaled));
    DualQp qp(9, scaled.limitedRows());
    ASSERT_TRUE(relaxation.start(qp));
    ASSERT_EQ(qp.minimise(relaxation.rows(), relaxation.limits(), kInfinity), DualQp::Outcome::kOptimal);
    const double bound = (qp.value() + relaxation.constant() - relaxation.calcSlack()) * scaled.objectiveUnit();
    const double rest = 0.5 * problem.e.squaredNorm();
    EXPECT_LE(bound, optimum + 1e-5 * optimum + 1e-8 * rest) << k;
    tightest = std::max(tightest, bound / optimum);
  }
  EXPECT_GT(tightest, 0.99);  // where the relaxed point happens to be complementary
}

TEST(QpccRelaxation, needsACurvedObjective) {
  // Nothing but the contacts' own compliance bends the objective, and efforts move them freely.
  QpccProblem problem({1, 0, 0, 1});
  problem.C_a << 1;
  problem.C_c << 1;
  problem.c << 1;
  ScaledQpcc scaled(problem.size);
  scaled.update(problem);
  QpccRelaxation relaxation(problem.size);
  EXPECT_TRUE(!relaxation.prepare(scaled) || relaxation.calcSlack() == kInfinity);
}

TEST(QpccRelaxation, canBeInterrupted) {
  struct Now : QpInterruption {
    bool due() override { return true; }
  } now;
  std::mt19937 random(3);
  const QpccProblem problem = makeQpcc(QpccKind::kBar, 3, 6, random);
  ScaledQpcc scaled(problem.size);
  scaled.update(problem);
  EXPECT_FALSE(QpccRelaxation(problem.size).prepare(scaled, &now));
}

}  // namespace
}  // namespace sinew
