#include "sinew/solver/active_factor.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>
#include <vector>

namespace sinew {
namespace {

constexpr int kVariables = 7;

class ActiveFactorTest : public testing::Test {
 protected:
  ActiveFactorTest() {
    const MatX factor = draw(kVariables + 1, kVariables);
    G_ = factor.transpose() * factor;
    normals_ = draw(kVariables, kVariables);
  }

  MatX draw(int rows, int columns) {
    return MatX::NullaryExpr(rows, columns, [this]() { return normal_(random_); });
  }

  MatX activeNormals() const {
    MatX result(kVariables, static_cast<int>(active_.size()));
    for (std::size_t j = 0; j < active_.size(); ++j) result.col(static_cast<int>(j)) = normals_.col(active_[j]);
    return result;
  }

  void append(int k) {
    factor_.project(normals_.col(k));
    ASSERT_FALSE(factor_.dependent(1e-10));
    factor_.append();
    active_.push_back(k);
  }

  void remove(int position) {
    factor_.remove(position);
    active_.erase(active_.begin() + position);
  }

  /// Compares with the dense KKT matrix [H -N; N^T 0].
  void expectSolves(const MatX& H) {
    const int q = factor_.size();
    MatX kkt = MatX::Zero(kVariables + q, kVariables + q);
    kkt.topLeftCorner(kVariables, kVariables) = H;
    kkt.topRightCorner(kVariables, q) = -activeNormals();
    kkt.bottomLeftCorner(q, kVariables) = activeNormals().transpose();
    const VecX right = draw(kVariables + q, 1);
    const VecX expected = kkt.fullPivLu().solve(right);
    VecX dx(kVariables), du(q);
    factor_.solve(right.head(kVariables), right.tail(q), dx, du);
    EXPECT_LE((dx - expected.head(kVariables)).norm(), 1e-10 * expected.norm());
    EXPECT_LE((du - expected.tail(q)).norm(), 1e-10 * expected.norm());
  }

  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  MatX G_, normals_;
  ActiveFactor factor_{kVariables};
  std::vector<int> active_;
};

TEST_F(ActiveFactorTest, SolvesTheKktSystemThroughAppendsAndRemovals) {
  factor_.reset(G_, 1e-4);
  EXPECT_FALSE(factor_.lifted());
  expectSolves(G_);
  for (int k = 0; k < kVariables; ++k) {
    append(k);
    expectSolves(G_);
  }
  for (const int position : {2, 5, 0, 3, 1, 1, 0}) {
    remove(position);
    expectSolves(G_);
  }
  for (const int k : {4, 1, 6}) append(k);
  expectSolves(G_);
}

TEST_F(ActiveFactorTest, DirectionsKeepTheActiveValues) {
  factor_.reset(G_, 1e-4);
  for (const int k : {0, 3, 5}) append(k);
  factor_.project(normals_.col(6));
  VecX z(kVariables), r(3);
  factor_.calcPrimalDirection(z);
  factor_.calcDualDirection(r);
  EXPECT_LE((activeNormals().transpose() * z).norm(), 1e-11);
  EXPECT_NEAR(factor_.curvature(), normals_.col(6).dot(z), 1e-11);
  EXPECT_LE((G_ * z - normals_.col(6) + activeNormals() * r).norm(), 1e-10);
}

TEST_F(ActiveFactorTest, KnowsACombinationOfTheActiveNormals) {
  factor_.reset(G_, 1e-4);
  for (const int k : {0, 3, 5}) append(k);
  const VecX combination = 2 * normals_.col(0) - normals_.col(3) + 0.5 * normals_.col(5);
  factor_.project(combination);
  EXPECT_TRUE(factor_.dependent(1e-10));
  VecX r(3);
  factor_.calcDualDirection(r);
  EXPECT_LE((r - Vec3(2, -1, 0.5)).norm(), 1e-11);
  factor_.project(combination + 1e-6 * normals_.col(6));
  EXPECT_FALSE(factor_.dependent(1e-10));
}

TEST_F(ActiveFactorTest, ProjectsAnUnknownLikeItsUnitVector) {
  factor_.reset(G_, 1e-4);
  factor_.project(VecX::Unit(kVariables, 2));
  const double expected = factor_.curvature();
  factor_.project(2);
  EXPECT_NEAR(factor_.curvature(), expected, 1e-14 * expected);
}

TEST_F(ActiveFactorTest, LiftsOnlyTheFlatDirections) {
  const MatX thin = draw(4, kVariables);
  G_ = thin.transpose() * thin;
  factor_.reset(G_, 1e-3);
  EXPECT_TRUE(factor_.lifted());
  EXPECT_EQ((factor_.proximal().array() != 0).count(), 3);
  EXPECT_LE((factor_.proximal().array() - 1e-3).maxCoeff(), 1e-12);
  for (const int k : {1, 2}) append(k);
  const MatX lift = VecX(factor_.proximal()).asDiagonal();
  expectSolves(G_ + lift);
}

}  // namespace
}  // namespace sinew
