#include "sinew/linalg/factor_pattern.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <set>

#include "linalg/random_matrix.h"
#include "sinew/linalg/elimination.h"

namespace sinew {
namespace {

/// A random layout, in its order of elimination.
struct Case {
  int blocks;
  std::vector<std::vector<int>> cliques;
  Elimination elimination;

  Case(unsigned seed, int block_count, int clique_count) : blocks(block_count) {
    std::mt19937 random(seed);
    cliques = makeRandomCliques(blocks, clique_count, 4, random);
    elimination = makeElimination(BlockPattern(blocks, cliques));
    std::vector<int> place(static_cast<std::size_t>(blocks));
    for (int k = 0; k < blocks; ++k) place[elimination.order[k]] = k;
    for (std::vector<int>& clique : cliques) {
      for (int& block : clique) block = block < 0 ? -1 : place[block];
    }
  }
  FactorPattern makePattern() const { return FactorPattern(BlockPattern(blocks, cliques), elimination.panel_start); }
  /// Blocks of the lower triangle of the factor that are not zero, by a dense one.
  std::vector<std::vector<bool>> makeFill() const {
    const BlockPattern pattern(blocks, cliques);
    BlockMatrix matrix(pattern);
    std::mt19937 random(5);
    addRandomGram(cliques, 1, random, matrix);
    const MatX L = matrix.makeDense().llt().matrixL();
    std::vector<std::vector<bool>> fill(static_cast<std::size_t>(blocks));
    for (int i = 0; i < blocks; ++i) {
      for (int j = 0; j <= i; ++j) fill[i].push_back(L.block<3, 3>(3 * i, 3 * j).cwiseAbs().maxCoeff() > 1e-12);
    }
    return fill;
  }
};

class FactorPatternTest : public testing::TestWithParam<int> {
 protected:
  Case layout{static_cast<unsigned>(GetParam()), 20 + 8 * GetParam(), 15 + 12 * GetParam()};
  FactorPattern pattern = layout.makePattern();

  bool holds(int row, int column) const {
    const auto& panel = pattern.panels()[pattern.panelOf(column)];
    if (row < panel.first + panel.own) return true;
    const auto begin = pattern.below().begin() + panel.below_begin;
    return std::binary_search(begin, begin + panel.below_count, row);
  }
};

TEST_P(FactorPatternTest, PanelsHoldTheWholeFactor) {
  const auto fill = layout.makeFill();
  for (int i = 0; i < layout.blocks; ++i) {
    for (int j = 0; j <= i; ++j) EXPECT_TRUE(!fill[i][j] || holds(i, j)) << i << " " << j;
  }
}

TEST_P(FactorPatternTest, TheMatrixHasAPlaceForEveryBlock) {
  const BlockPattern& matrix = pattern.matrix();
  for (int j = 0; j < matrix.blocks(); ++j) {
    const auto& panel = pattern.panels()[pattern.panelOf(j)];
    for (int k = matrix.columnStart()[j]; k < matrix.columnStart()[j + 1]; ++k) {
      const int place = pattern.matrixPlaces()[k] / 3;
      const bool own = place < panel.own;
      EXPECT_EQ(own ? panel.first + place : pattern.below()[panel.below_begin + place - panel.own], matrix.rows()[k]);
    }
  }
}

// Every panel that has rows in another one's columns updates it, from the first of them on.
TEST_P(FactorPatternTest, UpdatesNameTheirPlaces) {
  const auto& panels = pattern.panels();
  for (int target = 0; target < static_cast<int>(panels.size()); ++target) {
    std::set<int> sources;
    const int begin = panels[target].first, end = begin + panels[target].own;
    for (const auto* update = pattern.updatesBegin(target); update != pattern.updatesEnd(target); ++update) {
      const auto& source = panels[update->source];
      sources.insert(update->source);
      for (int k = update->first_row; k < source.below_count; ++k) {
        const int row = pattern.below()[source.below_begin + k];
        const int place = pattern.places()[update->place + k - update->first_row];
        EXPECT_EQ(k < update->first_row + update->column_count, row >= begin && row < end);
        const bool own = row < end;
        EXPECT_EQ(
            own ? begin + place / 3 : pattern.below()[panels[target].below_begin + place / 3 - panels[target].own],
            row);
      }
    }
    for (int source = 0; source < target; ++source) {
      const auto first = pattern.below().begin() + panels[source].below_begin;
      const bool reaches =
          std::any_of(first, first + panels[source].below_count, [&](int row) { return row >= begin && row < end; });
      EXPECT_EQ(reaches, sources.count(source) > 0);
    }
  }
}

TEST_P(FactorPatternTest, ParentsTakeAllThatIsLeft) {
  for (const auto& panel : pattern.panels()) {
    if (panel.below_count == 0) {
      EXPECT_EQ(panel.parent, -1);
      continue;
    }
    for (int k = 0; k < panel.below_count; ++k) {
      EXPECT_TRUE(holds(pattern.below()[panel.below_begin + k], pattern.panels()[panel.parent].first));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, FactorPatternTest, testing::Range(0, 6));

TEST(EliminationTest, EveryOrderStaysAPermutationInPanels) {
  std::mt19937 random(3);
  const BlockPattern pattern(90, makeRandomCliques(90, 150, 4, random));
  for (const BlockOrder& order :
       {orderByMinimumDegree(pattern), orderByNestedDissection(pattern), orderFromBothEnds(pattern)}) {
    const Elimination elimination = makeElimination(pattern, order);
    std::set<int> seen(elimination.order.begin(), elimination.order.end());
    EXPECT_EQ(seen.size(), 90U);
    EXPECT_TRUE(std::is_sorted(elimination.panel_start.begin(), elimination.panel_start.end()));
    EXPECT_EQ(elimination.panel_start.front(), 0);
    EXPECT_EQ(elimination.panel_start.back(), 90);
    EXPECT_GE(elimination.cost, makeElimination(pattern).cost);
  }
}

}  // namespace
}  // namespace sinew
