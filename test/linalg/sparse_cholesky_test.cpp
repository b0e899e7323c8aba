#include "sinew/linalg/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numeric>

#include "linalg/random_matrix.h"

namespace sinew {
namespace {

struct Layout {
  std::string name;
  int blocks;
  std::vector<std::vector<int>> cliques;
  bool supernodal;
};

Layout makeSparse() {
  std::mt19937 random(1);
  return {"Sparse", 80, makeRandomCliques(80, 90, 4, random), false};
}

/// Two large groups that share most of their nodes.
Layout makeCrowded() {
  std::vector<int> first(230), second(230);
  std::iota(first.begin(), first.end(), 0);
  std::iota(second.begin(), second.end(), 40);
  return {"Crowded", 270, {first, second}, true};
}

class SparseCholeskyTest : public testing::TestWithParam<Layout> {
 protected:
  std::mt19937 random{2};
  BlockPattern pattern{GetParam().blocks, GetParam().cliques};
  BlockMatrix matrix{pattern};
  SparseCholesky cholesky{pattern};
  int size = pattern.size();

  void makeMatrix(double shift) {
    matrix.setZero();
    addRandomGram(GetParam().cliques, shift, random, matrix);
  }

  void expectSolves() {
    const MatX dense = matrix.makeDense();
    const VecX right = makeRandom(size, 1, random);
    VecX x = right;
    cholesky.solve(x);
    EXPECT_LT((x - dense.llt().solve(right)).norm(), 1e-9 * x.norm());
    EXPECT_LT((dense * x - right).norm(), 1e-10 * right.norm());
  }
};

TEST_P(SparseCholeskyTest, SolvesAsTheDenseFactorDoes) {
  EXPECT_EQ(cholesky.size(), size);
  EXPECT_EQ(cholesky.supernodal(), GetParam().supernodal);
  makeMatrix(1);
  ASSERT_TRUE(cholesky.factorise(matrix));
  expectSolves();
  expectSolves();
}

TEST_P(SparseCholeskyTest, PermutesEveryDegreeOfFreedomOnce) {
  std::vector<bool> taken(static_cast<std::size_t>(size), false);
  for (int i = 0; i < size; ++i) {
    const int place = cholesky.permuted(i);
    ASSERT_TRUE(place >= 0 && place < size && !taken[place]);
    taken[place] = true;
  }
}

TEST_P(SparseCholeskyTest, HalvesMakeTheComplianceAndTheWholeSolve) {
  constexpr int kRows = 7;
  makeMatrix(1);
  ASSERT_TRUE(cholesky.factorise(matrix));
  const MatX right = makeRandom(size, kRows, random);
  const MatX solved = matrix.makeDense().llt().solve(right);
  MatX half = MatX::Constant(size, kRows + 2, 5.0);
  for (int i = 0; i < size; ++i) half.row(cholesky.permuted(i)).head(kRows) = right.row(i);
  cholesky.forwardSolve(half, kRows);
  EXPECT_EQ(half.rightCols(2), MatX::Constant(size, 2, 5.0));

  const MatX Y = half.leftCols(kRows);
  const MatX compliance = right.transpose() * solved;
  EXPECT_LT((Y.transpose() * Y - compliance).norm(), 1e-10 * compliance.norm());
  VecX x(size);
  for (int k = 0; k < kRows; ++k) {
    cholesky.backwardSolve(Y.col(k), x);
    EXPECT_LT((x - solved.col(k)).norm(), 1e-9 * x.norm());
  }
}

TEST_P(SparseCholeskyTest, FactorisesAgainWithOtherValues) {
  for (double shift : {1.0, 100.0, 0.5}) {
    makeMatrix(shift);
    ASSERT_TRUE(cholesky.factorise(matrix));
    expectSolves();
  }
}

// A negative eigenvalue anywhere, and recovery in the cycle after.
TEST_P(SparseCholeskyTest, RefusesAnIndefiniteMatrixAndRecovers) {
  for (int block : {0, pattern.blocks() / 2, pattern.blocks() - 1}) {
    makeMatrix(1);
    matrix.add(pattern.slot(block, block), -1e4 * Mat3::Identity());
    EXPECT_FALSE(cholesky.factorise(matrix));
    makeMatrix(1);
    ASSERT_TRUE(cholesky.factorise(matrix));
    expectSolves();
  }
}

TEST_P(SparseCholeskyTest, RefusesAMatrixOfNothing) {
  matrix.setZero();
  EXPECT_FALSE(cholesky.factorise(matrix));
}

INSTANTIATE_TEST_SUITE_P(Layouts, SparseCholeskyTest, testing::Values(makeSparse(), makeCrowded()),
                         [](const auto& layout) { return layout.param.name; });

}  // namespace
}  // namespace sinew
