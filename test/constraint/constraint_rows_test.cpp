#include "sinew/constraint/constraint_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "constraint/cable_bar.h"

namespace sinew {
namespace {

/// Rows of random entries, some on fixed nodes and some twice on one node, next to their dense twin.
class ConstraintRowsTest : public testing::Test {
 protected:
  static constexpr int kRows = 5;
  CableBar bar;
  std::mt19937 random{1};
  ConstraintRows rows{bar.fem, kRows, 100};
  MatX dense = MatX::Zero(kRows, bar.fem.size());

  ConstraintRowsTest() {
    for (int row = 0; row < kRows; ++row) {
      rows.beginRow();
      if (row == 2) continue;  // an empty row
      for (int k = 0; k < 15; ++k) {
        const int node = static_cast<int>(random() % static_cast<unsigned>(bar.fem.nodeCount()));
        const Vec3 derivative = makeVector();
        rows.add(node, derivative);
        if (bar.fem.freeIndex(node) >= 0) dense.row(row).segment<3>(3 * bar.fem.freeIndex(node)) += derivative;
      }
    }
  }

  Vec3 makeVector() {
    std::normal_distribution<double> normal;
    return Vec3(normal(random), normal(random), normal(random));
  }

  VecX makeFieldVector() {
    VecX x(bar.fem.size());
    for (int i = 0; i < bar.fem.freeCount(); ++i) x.segment<3>(3 * i) = makeVector();
    return x;
  }
};

TEST_F(ConstraintRowsTest, MultiplyFromEitherSideAsTheDenseMatrix) {
  const VecX x = makeFieldVector(), y = makeFieldVector();
  ASSERT_EQ(rows.rows(), kRows);
  for (int row = 0; row < kRows; ++row) {
    EXPECT_NEAR(rows.dot(row, x), dense.row(row).dot(x), 1e-12);
    VecX force = y;
    rows.addTransposed(row, -1.5, force);
    EXPECT_LT((force - (y - 1.5 * dense.row(row).transpose())).norm(), 1e-12);
  }
}

TEST_F(ConstraintRowsTest, ClearForgetsEveryRow) {
  rows.clear();
  EXPECT_EQ(rows.rows(), 0);
  rows.beginRow();
  rows.add(bar.fem.freeNodes()[4], Vec3(1, 2, 3));
  EXPECT_EQ(rows.rows(), 1);
  VecX expected = VecX::Zero(bar.fem.size());
  expected.segment<3>(12) = Vec3(1, 2, 3);
  EXPECT_EQ(makeDenseRow(rows, 0, bar.fem.size()), expected);
}

TEST_F(ConstraintRowsTest, SpreadAPointOverItsNodes) {
  const Vec3 direction = makeVector();
  rows.clear();
  rows.beginRow();
  rows.add(bar.points[0], direction);
  const std::vector<Vec3> positions = bar.makeDeformed(1, 1.1);
  const MatX expected = bar.differentiate(
      [&](const std::vector<Vec3>& x) { return VecX::Constant(1, direction.dot(calcPosition(bar.points[0], x))); },
      positions);
  EXPECT_LT((makeDenseRow(rows, 0, bar.fem.size()) - expected.transpose()).norm(), 1e-8);
}

TEST(CalcPosition, GivesBackThePlaceOfAPoint) {
  const CableBar bar;
  EXPECT_LT((calcPosition(bar.points[1], bar.fem.rest()) - Vec3(0.041, 0.016, 0.006)).norm(), 1e-15);
  std::vector<Vec3> moved = bar.fem.rest();
  Mat3 A;
  A << 1.1, 0.2, 0, -0.1, 0.9, 0.3, 0, 0.1, 1.2;
  for (Vec3& node : moved) node = A * node + Vec3(1, 2, 3);
  EXPECT_LT((calcPosition(bar.points[1], moved) - A * Vec3(0.041, 0.016, 0.006) - Vec3(1, 2, 3)).norm(), 1e-14);
}

}  // namespace
}  // namespace sinew
