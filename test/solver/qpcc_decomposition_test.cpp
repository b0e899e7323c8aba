#include "sinew/solver/qpcc_decomposition.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "random_qpcc.h"
#include "sinew/solver/contact_lcp.h"

namespace sinew {
namespace {

class Decomposition : public testing::Test {
 protected:
  void make(const QpccProblem& problem) {
    size_ = problem.size;
    scaled_ = std::make_unique<ScaledQpcc>(size_);
    scaled_->update(problem);
    tableau_ = std::make_unique<ComplementarityTableau>(size_);
    tableau_->reset(*scaled_);
    piece_ = std::make_unique<PieceQp>(size_);
    piece_->attach(*scaled_);
    visited_.clear();
    budget_.start(QpccBudget());
  }

  bool descend(bool elastic, QpccPoint& best) {
    return QpccDecomposition(size_).descend(elastic, *tableau_, *piece_, visited_, budget_, best);
  }

  std::mt19937 random_{1};
  QpccSizes size_;
  std::unique_ptr<ScaledQpcc> scaled_;
  std::unique_ptr<ComplementarityTableau> tableau_;
  std::unique_ptr<PieceQp> piece_;
  VisitedSets visited_{12};
  SearchBudget budget_;
};

TEST_F(Decomposition, endsWhereNoNamedContactHelps) {
  for (int k = 0; k < 200; ++k) {
    make(makeQpcc(static_cast<QpccKind>(k % 3), 3, 10, random_));
    ASSERT_TRUE(solveContactLcp(VecX::Zero(3), *tableau_));
    PieceAnswer first(size_);
    const bool feasible = piece_->solve(tableau_->map(), first);
    QpccPoint best(size_);
    ASSERT_EQ(descend(false, best), feasible);
    if (!feasible) continue;
    EXPECT_FALSE(isBetter(first.merit, best.answer.merit));
    tableau_->moveTo(best.active);
    PieceAnswer next(size_);
    for (const int contact : best.answer.candidates) {
      tableau_->pivot(contact);
      const bool solved = piece_->solve(tableau_->map(), next);
      EXPECT_FALSE(solved && isBetter(next.merit, best.answer.merit)) << k;
      tableau_->pivot(contact);
    }
  }
}

TEST_F(Decomposition, entersNoPieceTwice) {
  make(makeQpcc(QpccKind::kLever, 3, 10, random_));
  QpccPoint best(size_);
  ASSERT_TRUE(descend(false, best));
  tableau_->moveTo(best.active);
  EXPECT_FALSE(descend(false, best));
}

TEST_F(Decomposition, stopsWithItsBudget) {
  make(makeQpcc(QpccKind::kLever, 4, 20, random_));
  QpccBudget one;
  one.max_pieces = 1;
  budget_.start(one);
  QpccPoint best(size_);
  ASSERT_TRUE(descend(false, best));
  EXPECT_EQ(budget_.pieces(), 1);
}

TEST_F(Decomposition, leavesPiecesThatMissLimits) {
  int reached = 0;
  int missed = 0;
  for (int k = 0; k < 400; ++k) {
    make(makeQpcc(QpccKind::kRandom, 4, 10, random_));
    const VecX x = VecX::Random(4).cwiseAbs().cwiseProduct(scaled_->soft_upper);
    ASSERT_TRUE(solveContactLcp(x, *tableau_));
    PieceAnswer first(size_);
    if (piece_->solve(tableau_->map(), first)) continue;
    ++missed;
    QpccPoint best(size_);
    ASSERT_TRUE(descend(true, best)) << k;
    reached += best.answer.merit.feasible();
  }
  EXPECT_GT(missed, 5);
  EXPECT_GT(3 * reached, missed);
}

}  // namespace
}  // namespace sinew
