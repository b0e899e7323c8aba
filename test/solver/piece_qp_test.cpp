#include "sinew/solver/piece_qp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "qpcc_enumeration.h"
#include "random_qpcc.h"

namespace sinew {
namespace {

struct Scene {
  explicit Scene(const QpccProblem& problem)
      : scaled(problem.size), tableau(problem.size), piece(problem.size), answer(problem.size) {
    scaled.update(problem);
    tableau.reset(scaled);
    piece.attach(scaled);
  }
  double objective() const { return answer.merit.objective * scaled.objectiveUnit(); }

  ScaledQpcc scaled;
  ComplementarityTableau tableau;
  PieceQp piece;
  PieceAnswer answer;
};

TEST(PieceQp, agreesWithTheFullFormulation) {
  std::mt19937 random(1);
  int feasible = 0;
  for (int k = 0; k < 600; ++k) {
    const QpccProblem problem = makeQpcc(static_cast<QpccKind>(k % 3), 1 + k % 5, 5, random);
    Scene scene(problem);
    const std::vector<char> active = activeSetOf(static_cast<unsigned>(random()) & 15u, 5);
    scene.tableau.moveTo(active);
    const double full = FullQpcc(problem).solvePiece(active);
    ASSERT_EQ(scene.piece.solve(scene.tableau.map(), scene.answer), std::isfinite(full)) << k;
    if (!std::isfinite(full)) continue;
    ++feasible;
    const double scale = full + 1e-3 * 0.5 * problem.e.squaredNorm();
    EXPECT_NEAR(scene.objective(), full, 1e-5 * scale) << k;  // the lift
    EXPECT_TRUE(scene.answer.merit.feasible());
  }
  EXPECT_GT(feasible, 150);
}

TEST(PieceQp, namesContactsWhoseChangeHelps) {
  std::mt19937 random(2);
  int helped = 0;
  for (int k = 0; k < 300; ++k) {
    const QpccProblem problem = makeQpcc(QpccKind::kBar, 3, 6, random);
    Scene scene(problem);
    if (!scene.piece.solve(scene.tableau.map(), scene.answer) || scene.answer.candidates.empty()) continue;
    const PieceMerit before = scene.answer.merit;
    scene.tableau.pivot(scene.answer.candidates.front());
    ASSERT_TRUE(scene.piece.solve(scene.tableau.map(), scene.answer)) << k;  // both sides share the last point
    EXPECT_LE(scene.answer.merit.objective, before.objective * (1 + 1e-6) + 1e-9) << k;
    helped += isBetter(scene.answer.merit, before);
  }
  EXPECT_GT(helped, 30);
}

TEST(PieceQp, letsSoftLimitsGiveWayByTheLeast) {
  std::mt19937 random(3);
  int given_way = 0;
  for (int k = 0; k < 200; ++k) {
    QpccProblem problem = makeQpcc(QpccKind::kBar, 3, 0, random);
    holdRow(0, 1.5, problem);
    Scene scene(problem);
    ASSERT_TRUE(scene.piece.solveElastic(scene.tableau.map(), scene.answer)) << k;
    EXPECT_EQ(scene.answer.merit.row_violation, 0);
    const double least = FullQpcc(problem).enumerateSoftViolation();
    EXPECT_NEAR(scene.answer.merit.soft_violation, least, 1e-7 * (1 + least)) << k;
    given_way += least > 0.01;
  }
  EXPECT_GT(given_way, 100);
}

TEST(PieceQp, missesRowsByTheLeast) {
  QpccProblem problem({1, 2, 1, 0});
  problem.E_a << 1;
  problem.Q << 1e-3;
  problem.A_a << 1, 1;
  problem.row_lower << 1, -1;
  problem.row_upper << 2, 0;
  problem.soft_lower << 5;
  problem.soft_upper << 6;
  Scene scene(problem);
  ASSERT_FALSE(scene.piece.solve(scene.tableau.map(), scene.answer));
  ASSERT_TRUE(scene.piece.solveElastic(scene.tableau.map(), scene.answer));
  EXPECT_NEAR(scene.answer.merit.row_violation * scene.scaled.magnitude / scene.scaled.row_scale(0), 0.5, 1e-6);
  EXPECT_NEAR(scene.answer.x(0) * scene.scaled.magnitude * scene.scaled.unknown_unit(0), 0.5, 1e-6);
  EXPECT_GT(scene.answer.merit.soft_violation, 0);
}

TEST(PieceQp, polishesFlatObjectives) {
  // Two actuators that do the same, no energy term: only their sum is determined.
  QpccProblem problem({2, 0, 1, 0});
  problem.E_a << 1, 1;
  problem.e << -3;
  problem.x_lower << 0, 0;
  problem.x_upper << 2, 2;
  Scene scene(problem);
  ASSERT_TRUE(scene.piece.solve(scene.tableau.map(), scene.answer));
  const PieceMerit merit = scene.answer.merit;
  ASSERT_TRUE(scene.piece.polish(scene.tableau.map(), merit, scene.answer));
  EXPECT_NEAR(scene.answer.x.sum() * scene.scaled.magnitude * scene.scaled.unknown_unit(0), 3, 1e-12);
}

TEST(PieceMerit, ordersFirstThingsFirst) {
  EXPECT_TRUE(isBetter({0, 0.5, 9}, {0.1, 0, 1}));
  EXPECT_TRUE(isBetter({0, 0, 9}, {0, 0.5, 1}));
  EXPECT_TRUE(isBetter({0, 0, 1}, {0, 0, 2}));
  EXPECT_FALSE(isBetter({0, 0, 1}, {0, 0, 1 + 1e-12}));
}

}  // namespace
}  // namespace sinew
