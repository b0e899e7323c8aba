#include "sinew/solver/search_budget.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(SearchBudget, endsByCounts) {
  QpccBudget allowed;
  allowed.max_pieces = 2;
  allowed.max_nodes = 1;
  SearchBudget budget;
  budget.start(allowed);
  budget.countPiece();
  EXPECT_TRUE(budget.piecesLeft());
  budget.countPiece();
  EXPECT_FALSE(budget.piecesLeft());
  EXPECT_TRUE(budget.nodesLeft());
  budget.countNode();
  EXPECT_FALSE(budget.nodesLeft());
  EXPECT_FALSE(budget.deadlinePassed());
  budget.start(allowed);
  EXPECT_TRUE(budget.piecesLeft());
}

TEST(SearchBudget, endsByDeadline) {
  QpccBudget allowed;
  allowed.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  SearchBudget budget;
  budget.start(allowed);
  EXPECT_FALSE(budget.piecesLeft());
  EXPECT_FALSE(budget.nodesLeft());
  EXPECT_TRUE(budget.deadlinePassed());
}

}  // namespace
}  // namespace sinew
