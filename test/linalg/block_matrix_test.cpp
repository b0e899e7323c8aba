#include "sinew/linalg/block_matrix.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "linalg/random_matrix.h"

namespace sinew {
namespace {

constexpr int kBlocks = 30;

using Blocks = std::map<std::pair<int, int>, Mat3>;

/// The lower blocks that the cliques couple, each a random one; symmetric on the diagonal.
Blocks makeRandomBlocks(const std::vector<std::vector<int>>& cliques, std::mt19937& random) {
  Blocks blocks;
  for (int i = 0; i < kBlocks; ++i) blocks[{i, i}];
  for (const std::vector<int>& clique : cliques) {
    for (int row : clique) {
      for (int column : clique) {
        if (row >= 0 && column >= 0 && row > column) blocks[{row, column}];
      }
    }
  }
  for (auto& [place, block] : blocks) {
    block = makeRandom(3, 3, random);
    if (place.first == place.second) block = (block + block.transpose()).eval();
  }
  return blocks;
}

MatX makeDense(const Blocks& blocks) {
  MatX dense = MatX::Zero(3 * kBlocks, 3 * kBlocks);
  for (const auto& [place, block] : blocks) {
    dense.block<3, 3>(3 * place.first, 3 * place.second) = block;
    dense.block<3, 3>(3 * place.second, 3 * place.first) = block.transpose();
  }
  return dense;
}

class BlockMatrixTest : public testing::Test {
 protected:
  std::mt19937 random{1};
  std::vector<std::vector<int>> cliques = makeRandomCliques(kBlocks, 25, 4, random);
  BlockPattern pattern{kBlocks, cliques};
  Blocks blocks = makeRandomBlocks(cliques, random);
  MatX dense = makeDense(blocks);

  BlockMatrix makeMatrix() const {
    BlockMatrix matrix(pattern);
    for (const auto& [place, block] : blocks) matrix.add(pattern.slot(place.first, place.second), block);
    return matrix;
  }
};

TEST_F(BlockMatrixTest, HasASlotOfItsOwnForEveryPair) {
  EXPECT_EQ(pattern.blocks(), kBlocks);
  EXPECT_EQ(pattern.size(), 3 * kBlocks);
  EXPECT_EQ(pattern.blockCount(), static_cast<int>(blocks.size()));
  std::set<int> taken;
  for (const auto& item : blocks) {
    const BlockSlot slot = pattern.slot(item.first.first, item.first.second);
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) EXPECT_TRUE(taken.insert(slot.first + c * slot.stride + r).second);
    }
  }
  EXPECT_EQ(*taken.begin(), 0);
  EXPECT_EQ(*taken.rbegin(), 9 * pattern.blockCount() - 1);
}

TEST_F(BlockMatrixTest, ReadsAsCompressedColumns) {
  const BlockMatrix matrix = makeMatrix();
  MatX lower = MatX::Zero(pattern.size(), pattern.size());
  std::size_t next = 0;
  for (int j = 0; j < pattern.blocks(); ++j) {
    EXPECT_EQ(pattern.rows()[pattern.columnStart()[j]], j);
    for (int c = 0; c < 3; ++c) {
      for (int k = pattern.columnStart()[j]; k < pattern.columnStart()[j + 1]; ++k) {
        for (int r = 0; r < 3; ++r) lower(3 * pattern.rows()[k] + r, 3 * j + c) = matrix.values()[next++];
      }
    }
  }
  EXPECT_EQ(next, matrix.values().size());
  const MatX expected = dense.triangularView<Eigen::Lower>();
  EXPECT_EQ(MatX(lower.triangularView<Eigen::Lower>()), expected);
}

TEST_F(BlockMatrixTest, MakesItselfDense) {
  EXPECT_EQ(makeMatrix().makeDense(), dense);
}

TEST_F(BlockMatrixTest, AddsUpAndScales) {
  BlockMatrix matrix = makeMatrix();
  for (const auto& [place, block] : blocks) matrix.add(pattern.slot(place.first, place.second), block);
  matrix.scale(-1.5);
  EXPECT_LT((matrix.makeDense() + 3 * dense).norm(), 1e-14 * dense.norm());
  matrix.setZero();
  EXPECT_EQ(matrix.makeDense().norm(), 0);
}

TEST_F(BlockMatrixTest, MultipliesAsTheWholeSymmetricMatrix) {
  const BlockMatrix matrix = makeMatrix();
  const VecX x = makeRandom(pattern.size(), 1, random), y = makeRandom(pattern.size(), 1, random);
  VecX result = y;
  matrix.addProduct(-0.7, x, result);
  EXPECT_LT((result - (y - 0.7 * dense * x)).norm(), 1e-13 * dense.norm() * x.norm());
}

TEST(BlockPattern, PassesOverFixedNodes) {
  const BlockPattern pattern(3, {{-1, 2, 0, -1}, {-1, -1}, {}});
  EXPECT_EQ(pattern.rows(), (std::vector<int>{0, 2, 1, 2}));
  EXPECT_EQ(pattern.columnStart(), (std::vector<int>{0, 2, 3, 4}));
}

}  // namespace
}  // namespace sinew
