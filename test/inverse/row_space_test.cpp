#include "sinew/inverse/row_space.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <random>

namespace sinew {
namespace {

MatX makeRandom(int rows, int columns, std::mt19937& random) {
  std::normal_distribution<double> normal;
  MatX matrix(rows, columns);
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < rows; ++r) matrix(r, c) = normal(random);
  }
  return matrix;
}

// The projector on the row space does not depend on the basis: compared with that of the singular vectors.
TEST(RowSpace, SpansTheRowsAndNothingElse) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 500; ++trial) {
    const int rows = 1 + static_cast<int>(random() % 9), columns = 1 + static_cast<int>(random() % 8);
    const int rank = 1 + static_cast<int>(random() % static_cast<unsigned>(std::min(rows, columns)));
    const MatX matrix = makeRandom(rows, rank, random) * makeRandom(rank, columns, random);
    RowSpace space(9, columns);
    space.update(matrix, rows, 1e-9);
    ASSERT_EQ(space.rank(), rank);
    const MatX basis = space.basis().topRows(rank);
    EXPECT_LT((basis * basis.transpose() - MatX::Identity(rank, rank)).norm(), 1e-12);
    const MatX V = Eigen::JacobiSVD<MatX>(matrix, Eigen::ComputeThinV).matrixV().leftCols(rank);
    EXPECT_LT((basis.transpose() * basis - V * V.transpose()).norm(), 1e-6);
  }
}

TEST(RowSpace, StaysOrthonormalForNearlyParallelRows) {
  std::mt19937 random(2);
  MatX matrix = makeRandom(1, 6, random).replicate(4, 1) + 1e-7 * makeRandom(4, 6, random);
  RowSpace space(4, 6);
  space.update(matrix, 4, 1e-12);
  ASSERT_EQ(space.rank(), 4);
  EXPECT_LT((space.basis() * space.basis().transpose() - MatX::Identity(4, 4)).norm(), 1e-12);
}

TEST(RowSpace, PassesOverWhatIsShorterThanTheTolerance) {
  MatX matrix = MatX::Zero(3, 4);
  matrix(0, 1) = 1e-4;
  matrix(1, 0) = 10;
  matrix(2, 0) = -3;
  RowSpace space(3, 4);
  space.update(matrix, 3, 1e-4);
  EXPECT_EQ(space.rank(), 1);
  space.update(matrix, 3, 1e-6);
  EXPECT_EQ(space.rank(), 2);
}

TEST(RowSpace, ReadsTheLeadingRowsOnly) {
  RowSpace space(3, 3);
  space.update(MatX::Identity(3, 3), 2, 1e-9);
  EXPECT_EQ(space.rank(), 2);
  space.update(MatX::Identity(3, 3), 0, 1e-9);
  EXPECT_EQ(space.rank(), 0);
  space.update(MatX::Zero(3, 3), 3, 1e-9);
  EXPECT_EQ(space.rank(), 0);
}

}  // namespace
}  // namespace sinew
