#include "sinew/linalg/ordering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "linalg/random_matrix.h"

namespace sinew {
namespace {

std::vector<std::vector<int>> makeChain(int blocks) {
  std::vector<std::vector<int>> links;
  for (int i = 0; i + 1 < blocks; ++i) links.push_back({i, i + 1});
  return links;
}

void expectPermutation(BlockOrder order, int blocks) {
  std::sort(order.begin(), order.end());
  BlockOrder all(static_cast<std::size_t>(blocks));
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(order, all);
}

TEST(OrderingTest, OrdersEveryBlockOnce) {
  std::mt19937 random(1);
  for (const int blocks : {1, 2, 7, 60}) {
    for (const int cliques : {0, 1, 40}) {
      const BlockPattern pattern(blocks, makeRandomCliques(blocks, cliques, std::min(blocks, 4), random));
      expectPermutation(orderByMinimumDegree(pattern), blocks);
      expectPermutation(orderByNestedDissection(pattern), blocks);
      expectPermutation(orderFromBothEnds(pattern), blocks);
    }
  }
}

TEST(OrderingTest, TheGraphHasBothTriangles) {
  const BlockGraph graph(BlockPattern(4, {{0, 2}, {1, 2, 3}}));
  EXPECT_EQ(graph.start, (std::vector<int>{0, 1, 3, 6, 8}));
  std::vector<int> of_2(graph.neighbour.begin() + 3, graph.neighbour.begin() + 6);
  std::sort(of_2.begin(), of_2.end());
  EXPECT_EQ(of_2, (std::vector<int>{0, 1, 3}));
}

// Whatever the numbering, both ends come first and the middle last.
TEST(OrderingTest, GoesAlongASlenderBodyFromBothEnds) {
  constexpr int kBlocks = 41;
  std::mt19937 random(2);
  std::vector<int> name(kBlocks);
  std::iota(name.begin(), name.end(), 0);
  std::shuffle(name.begin(), name.end(), random);
  std::vector<std::vector<int>> links = makeChain(kBlocks);
  for (std::vector<int>& link : links) {
    for (int& block : link) block = name[block];
  }
  const BlockOrder order = orderFromBothEnds(BlockPattern(kBlocks, links));
  for (int k = 0; k < kBlocks; ++k) {
    const int along = static_cast<int>(std::find(name.begin(), name.end(), order[k]) - name.begin());
    EXPECT_EQ(std::min(along, kBlocks - 1 - along), k / 2);
  }
}

}  // namespace
}  // namespace sinew
