#include "sinew/solver/contact_lcp.h"

#include <gtest/gtest.h>

#include <random>

#include "random_qpcc.h"

namespace sinew {
namespace {

struct Scene {
  explicit Scene(const QpccProblem& problem) : scaled(problem.size), tableau(problem.size) {
    scaled.update(problem);
    tableau.reset(scaled);
  }
  VecX calcRows(const VecX& x) const { return tableau.map().leftCols(x.size()) * x + tableau.map().col(x.size()); }
  ScaledQpcc scaled;
  ComplementarityTableau tableau;
};

TEST(ContactLcp, leavesNoNegativeGapOrForce) {
  std::mt19937 random(1);
  for (int k = 0; k < 300; ++k) {
    QpccProblem problem = makeQpcc(static_cast<QpccKind>(k % 3), 3, 12, random);
    if (k % 5 == 0) averageContacts(0, 1, 2, problem);
    Scene scene(problem);
    const VecX x = VecX::Random(3);
    ASSERT_TRUE(solveContactLcp(x, scene.tableau)) << k;
    EXPECT_GE(scene.calcRows(x).head(scene.scaled.size.contacts).minCoeff(), -1e-9) << k;
  }
}

TEST(ContactLcp, holdsDisplacements) {
  std::mt19937 random(2);
  int held_rows = 0;
  for (int k = 0; k < 300; ++k) {
    QpccProblem problem = makeQpcc(static_cast<QpccKind>(k % 3), 4, 10, random);
    holdRow(0, 0.5, problem);
    if (k % 2 == 0) holdRow(2, 0.3, problem);
    Scene scene(problem);
    const MatX before = scene.tableau.map();
    std::vector<HeldRow> held;
    pairEqualities(scene.tableau, held);
    ASSERT_EQ(held.size(), k % 2 == 0 ? 2u : 1u);
    EXPECT_LE((scene.tableau.map() - before).norm(), 1e-9 * before.norm());
    VecX x = VecX::Zero(4);
    ASSERT_TRUE(solveContactMcp(held, x, scene.tableau)) << k;
    const int nc = scene.scaled.size.contacts;
    const VecX rows = scene.calcRows(x);
    EXPECT_GE(rows.head(nc).minCoeff(), -1e-8) << k;
    for (const HeldRow& pair : held) {
      EXPECT_NEAR(rows(nc + pair.row), scene.scaled.row_lower(nc + pair.row), 1e-8) << k;
      ++held_rows;
    }
  }
  EXPECT_EQ(held_rows, 450);
}

TEST(ContactLcp, refusesARowItsUnknownCannotMove) {
  std::mt19937 random(3);
  QpccProblem problem = makeQpcc(QpccKind::kBar, 2, 3, random);
  problem.A_a.row(0).setZero();
  holdRow(0, 0.5, problem);
  Scene scene(problem);
  std::vector<HeldRow> held;
  pairEqualities(scene.tableau, held);
  EXPECT_TRUE(held.empty());
  VecX x = VecX::Zero(2);
  EXPECT_FALSE(solveContactMcp({{0, 0}}, x, scene.tableau));
}

}  // namespace
}  // namespace sinew
