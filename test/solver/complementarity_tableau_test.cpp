#include "sinew/solver/complementarity_tableau.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include "check_line.h"
#include "random_qpcc.h"

namespace sinew {
namespace {

class Tableau : public testing::Test {
 protected:
  void make(QpccKind kind, int unknowns, int contacts) {
    problem_ = std::make_unique<QpccProblem>(makeQpcc(kind, unknowns, contacts, random_));
    attach();
  }
  void attach() {
    scaled_ = std::make_unique<ScaledQpcc>(problem_->size);
    scaled_->update(*problem_);
    tableau_ = std::make_unique<ComplementarityTableau>(problem_->size);
    tableau_->reset(*scaled_);
  }

  /// Gaps and forces, limited rows and effectors of the present piece at x, by elimination.
  VecX calcPiece(const VecX& x, double lift) const {
    const int nc = scaled_->size.contacts;
    std::vector<int> active;
    for (int i = 0; i < nc; ++i)
      if (tableau_->isActive(i)) active.push_back(i);
    const auto count = static_cast<Eigen::Index>(active.size());
    VecX columns = VecX::Zero(scaled_->tableColumns());
    columns.segment(nc, x.size()) = x;
    columns(nc + x.size()) = 1;
    const VecX free = scaled_->table * columns;
    MatX C(count, count);
    VecX gap(count);
    for (Eigen::Index r = 0; r < count; ++r) {
      for (Eigen::Index k = 0; k < count; ++k)
        C(r, k) = scaled_->table(active[static_cast<std::size_t>(r)], active[static_cast<std::size_t>(k)]) +
                  (r == k ? lift : 0);
      gap(r) = free(active[static_cast<std::size_t>(r)]);
    }
    const VecX z = count > 0 ? VecX(C.fullPivLu().solve(-gap)) : VecX();
    for (Eigen::Index k = 0; k < count; ++k) columns(active[static_cast<std::size_t>(k)]) = z(k);
    VecX values = scaled_->table * columns;
    for (Eigen::Index k = 0; k < count; ++k) values(active[static_cast<std::size_t>(k)]) = z(k);
    return values;
  }

  VecX calcMapped(const MatX& map, const VecX& x) const { return map.leftCols(x.size()) * x + map.col(x.size()); }

  std::mt19937 random_{1};
  std::unique_ptr<QpccProblem> problem_;
  std::unique_ptr<ScaledQpcc> scaled_;
  std::unique_ptr<ComplementarityTableau> tableau_;
};

TEST_F(Tableau, givesThePieceOfItsActiveSet) {
  for (int k = 0; k < 60; ++k) {
    make(static_cast<QpccKind>(k % 3), 3, 8);
    for (int i = 0; i < 8; ++i)
      if (random_() % 2 == 0) tableau_->pivot(i);
    const VecX x = VecX::Random(3);
    const VecX expected = calcPiece(x, ComplementarityTableau::kLift);
    EXPECT_LE((calcMapped(tableau_->map(), x) - expected).norm(), 1e-9 * (1 + expected.norm())) << k;
  }
}

TEST_F(Tableau, refinesTheLiftAway) {
  for (int k = 0; k < 60; ++k) {
    make(static_cast<QpccKind>(k % 3), 3, 8);
    for (int i = 0; i < 8; ++i)
      if (random_() % 2 == 0) tableau_->pivot(i);
    MatX map = tableau_->map();
    ASSERT_TRUE(tableau_->refine(map));
    const VecX x = VecX::Random(3);
    const VecX expected = calcPiece(x, 0);
    EXPECT_LE((calcMapped(map, x) - expected).norm(), 1e-10 * (1 + expected.norm())) << k;
  }
}

TEST_F(Tableau, survivesDependentContacts) {
  make(QpccKind::kRandom, 2, 5);
  averageContacts(0, 1, 2, *problem_);
  attach();
  ASSERT_EQ(scaled_->size.contacts, 5);
  for (int i = 0; i < 3; ++i) tableau_->pivot(i);
  EXPECT_TRUE(tableau_->map().allFinite());
  EXPECT_LE(tableau_->calcDrift(), 1e-7);
  MatX map = tableau_->map();
  EXPECT_FALSE(tableau_->refine(map));  // the gaps contradict each other
}

TEST_F(Tableau, driftsLittle) {
  make(QpccKind::kRandom, 8, 40);
  const MatX fresh = tableau_->columns();
  for (int k = 0; k < 100000; ++k) tableau_->pivot(static_cast<int>(random_() % 40));
  const double drift = tableau_->calcDrift();
  for (int i = 0; i < 40; ++i)
    if (tableau_->isActive(i)) tableau_->pivot(i);
  EXPECT_EQ(tableau_->activeCount(), 0);
  EXPECT_EQ(tableau_->hash(), 0u);
  const double difference = (tableau_->columns() - fresh).cwiseAbs().maxCoeff();
  checkFigure("complementarity_tableau.drift", std::max(drift, difference), "<=", 1e-9, "1");
}

TEST_F(Tableau, rebuildsAndMoves) {
  make(QpccKind::kBar, 3, 10);
  std::vector<char> active(10, 0);
  active[1] = active[4] = active[7] = 1;
  tableau_->moveTo(active);
  EXPECT_EQ(tableau_->active(), active);
  const MatX moved = tableau_->map();
  const std::uint64_t hash = tableau_->hash();
  tableau_->rebuild();
  EXPECT_EQ(tableau_->active(), active);
  EXPECT_EQ(tableau_->hash(), hash);
  EXPECT_LE((tableau_->map() - moved).norm(), 1e-9 * moved.norm());
  const std::uint64_t after = tableau_->hashAfter(4);
  tableau_->pivot(4);
  EXPECT_EQ(tableau_->hash(), after);
}

TEST_F(Tableau, tellsActiveSetsApart) {
  make(QpccKind::kBar, 2, 10);
  std::set<std::uint64_t> hashes;
  for (unsigned k = 1; k <= 1024; ++k) {
    EXPECT_TRUE(hashes.insert(tableau_->hash()).second);
    int moved = 0;
    while (!((k >> moved) & 1u)) ++moved;
    tableau_->pivot(std::min(moved, 9));
  }
}

TEST_F(Tableau, exchangesARowWithAnUnknown) {
  make(QpccKind::kRandom, 3, 4);
  tableau_->pivot(2);
  const MatX before = tableau_->map();
  const VecX x = VecX::Random(3);
  const VecX values = calcMapped(before, x);
  tableau_->exchange(1, 0);
  VecX given = x;
  given(0) = values(4 + 1);
  const VecX follows = calcMapped(tableau_->map(), given);
  EXPECT_NEAR(follows(4 + 1), x(0), 1e-9);
  EXPECT_NEAR(follows(0), values(0), 1e-9);
  EXPECT_NEAR(follows(4), values(4), 1e-9);
  tableau_->exchange(1, 0);
  EXPECT_LE((tableau_->map() - before).norm(), 1e-9 * before.norm());
}

}  // namespace
}  // namespace sinew
