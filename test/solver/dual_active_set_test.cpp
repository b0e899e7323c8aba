#include "sinew/solver/dual_active_set.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// minimise x^2 / 2 + y^2 / 2 + z^2 / 2 with x + y + z >= 3 and free bounds
ScaledQp makeCorner() {
  ScaledQp qp(3, 1);
  qp.variables = 3;
  qp.rows = 1;
  qp.G.setIdentity();
  qp.g.setZero();
  qp.normals.setOnes();
  qp.lower.setConstant(-kInfinity);
  qp.upper.setConstant(kInfinity);
  qp.lower(3) = 3;
  return qp;
}

TEST(DualActiveSet, AddsAViolatedRow) {
  const ScaledQp qp = makeCorner();
  DualActiveSet active_set(3, 1);
  active_set.start(qp, 1e-4);
  ASSERT_EQ(active_set.minimise(VecX::Zero(3), 10), QpStatus::kSolved);
  EXPECT_LE((active_set.x() - VecX::Ones(3)).norm(), 1e-14);
  EXPECT_NEAR(active_set.dual()(3), 1, 1e-14);
  EXPECT_EQ(active_set.iterations(), 1);
}

TEST(DualActiveSet, DropsAConstraintThatAnotherMakesIdle) {
  // x >= 1 is violated most and enters first; the row then pushes x beyond it.
  ScaledQp qp = makeCorner();
  qp.normals.col(0) << 1, 0.1, 0.1;
  qp.lower(3) = 3;
  qp.lower(0) = 1;
  qp.g(0) = 10;
  DualActiveSet active_set(3, 1);
  active_set.start(qp, 1e-4);
  ASSERT_EQ(active_set.minimise(VecX::Zero(3), 10), QpStatus::kSolved);
  EXPECT_EQ(active_set.dual()(0), 0);
  EXPECT_GT(active_set.dual()(3), 0);
  EXPECT_GT(active_set.x()(0), 1);
}

TEST(DualActiveSet, StartsFromTheLastActiveSet) {
  ScaledQp qp = makeCorner();
  DualActiveSet active_set(3, 1);
  active_set.start(qp, 1e-4);
  active_set.minimise(VecX::Zero(3), 10);
  active_set.start(qp, 1e-4);
  ASSERT_EQ(active_set.minimise(VecX::Zero(3), 10), QpStatus::kSolved);
  EXPECT_EQ(active_set.iterations(), 0);

  qp.g.setConstant(-5);  // the row is idle now: its guess has to go
  active_set.start(qp, 1e-4);
  ASSERT_EQ(active_set.minimise(VecX::Zero(3), 10), QpStatus::kSolved);
  EXPECT_EQ(active_set.iterations(), 1);
  EXPECT_EQ(active_set.dual()(3), 0);
  EXPECT_LE((active_set.x() - VecX::Constant(3, 5)).norm(), 1e-13);
}

TEST(DualActiveSet, ForgetsTheLastActiveSet) {
  const ScaledQp qp = makeCorner();
  DualActiveSet active_set(3, 1);
  for (int round = 0; round < 2; ++round) {
    active_set.forget();
    active_set.start(qp, 1e-4);
    ASSERT_EQ(active_set.minimise(VecX::Zero(3), 10), QpStatus::kSolved);
    EXPECT_EQ(active_set.iterations(), 1);
  }
}

TEST(DualActiveSet, PullsFlatDirectionsTowardsTheCentre) {
  ScaledQp qp = makeCorner();
  qp.G(2, 2) = 0;
  qp.lower(3) = -kInfinity;
  DualActiveSet active_set(3, 1);
  active_set.start(qp, 1e-4);
  ASSERT_EQ(active_set.minimise(Vec3(4, 5, 6), 10), QpStatus::kSolved);
  EXPECT_LE((active_set.x() - Vec3(0, 0, 6)).norm(), 1e-13);
}

TEST(DualActiveSet, LeavesTheCertificateInTheDuals) {
  ScaledQp qp = makeCorner();
  qp.upper.head(3).setZero();
  DualActiveSet active_set(3, 1);
  active_set.start(qp, 1e-4);
  ASSERT_EQ(active_set.minimise(VecX::Zero(3), 20), QpStatus::kInfeasible);
  const VecX dual = active_set.dual();
  EXPECT_GT(dual(3), 0);
  EXPECT_LE((dual.head(3) + VecX::Constant(3, dual(3))).norm(), 1e-14);
}

}  // namespace
}  // namespace sinew
