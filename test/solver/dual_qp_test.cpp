#include "sinew/solver/dual_qp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "random_qp.h"
#include "sinew/solver/dense_qp.h"

namespace sinew {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A QP in the form that DualQp reads.
struct View {
  explicit View(const QpProblem& problem) : map(problem.rows, problem.variables + 1), limits(0) {
    map << problem.C, VecX::Zero(problem.rows);
    limits.lower.resize(problem.rows + problem.variables);
    limits.lower << problem.row_lower, problem.lower;
    limits.upper.resize(problem.rows + problem.variables);
    limits.upper << problem.row_upper, problem.upper;
  }

  QpRows rows() const { return makeQpRows(map, map.rows()); }

  MatX map;
  QpLimits limits;
};

QpProblem makeConvex(int variables, int rows, bool feasible, std::mt19937& random) {
  QpProblem problem = feasible ? makeFeasibleQp(variables, rows, random) : makeInfeasibleQp(variables, rows, random);
  problem.G.diagonal().array() += 0.1;
  return problem;
}

double calcObjective(const QpProblem& problem, const VecX& x) {
  return x.dot(0.5 * problem.G * x + problem.g);
}

TEST(DualQp, agreesWithDenseQp) {
  std::mt19937 random(3);
  for (int k = 0; k < 500; ++k) {
    const int n = 1 + static_cast<int>(random() % 12);
    const int m = static_cast<int>(random() % 30);
    const QpProblem problem = makeConvex(n, m, true, random);
    DenseQp reference(n, m);
    QpSolution solution(n, m);
    ASSERT_EQ(reference.solve(problem, solution), QpStatus::kSolved);
    const View view(problem);
    DualQp qp(n, m);
    ASSERT_TRUE(qp.start(problem.G, problem.g));
    ASSERT_EQ(qp.minimise(view.rows(), view.limits, kInfinity), DualQp::Outcome::kOptimal);
    qp.settle(view.rows(), view.limits);
    const double scale = 1 + std::abs(solution.objective);
    EXPECT_NEAR(calcObjective(problem, qp.x()), solution.objective, 1e-8 * scale) << k;
    EXPECT_NEAR(qp.value(), solution.objective, 1e-7 * scale) << k;
    EXPECT_LE((qp.x() - solution.x).norm(), 1e-7 * (1 + solution.x.norm())) << k;
  }
}

// Wherever it starts, the end is the same; and the start is a bound.
TEST(DualQp, startsWithUnknownsAtZero) {
  std::mt19937 random(6);
  int kept = 0;
  for (int k = 0; k < 500; ++k) {
    const int n = 1 + static_cast<int>(random() % 14);
    const int m = static_cast<int>(random() % 20);
    const QpProblem problem = makeConvex(n, m, true, random);
    View view(problem);
    view.limits.lower.tail(n).setZero();
    view.limits.upper.tail(n).setConstant(kInfinity);
    DualQp cold(n, m), warm(n, m);
    ASSERT_TRUE(cold.start(problem.G, problem.g));
    const DualQp::Outcome outcome = cold.minimise(view.rows(), view.limits, kInfinity);
    std::vector<char> held(static_cast<std::size_t>(n));
    for (char& hold : held) hold = random() % 3 > 0 ? 1 : 0;
    ASSERT_TRUE(warm.start(problem.G, problem.g, held));
    for (int i = 0; i < n; ++i) {
      if (!warm.isHeld(i)) continue;
      EXPECT_TRUE(held[static_cast<std::size_t>(i)]);
      EXPECT_GE(warm.boundDual(i), 0);
      EXPECT_EQ(warm.x()(i), 0);
      ++kept;
    }
    const double bound = warm.value();
    EXPECT_NEAR(bound, calcObjective(problem, warm.x()), 1e-9 * (1 + std::abs(bound)));
    ASSERT_EQ(warm.minimise(view.rows(), view.limits, kInfinity), outcome) << k;
    if (outcome != DualQp::Outcome::kOptimal) continue;
    EXPECT_NEAR(warm.value(), cold.value(), 1e-8 * (1 + std::abs(cold.value())));
    EXPECT_LE(bound, warm.value() + 1e-9 * (1 + std::abs(bound)));
    EXPECT_LE((warm.x() - cold.x()).norm(), 1e-7 * (1 + cold.x().norm())) << k;
  }
  EXPECT_GT(kept, 500);
}

TEST(DualQp, seesInfeasibility) {
  std::mt19937 random(4);
  for (int k = 0; k < 200; ++k) {
    const int n = 1 + static_cast<int>(random() % 8);
    const int m = 2 + static_cast<int>(random() % 20);
    const QpProblem problem = makeConvex(n, m, false, random);
    const View view(problem);
    DualQp qp(n, m);
    ASSERT_TRUE(qp.start(problem.G, problem.g));
    EXPECT_EQ(qp.minimise(view.rows(), view.limits, kInfinity), DualQp::Outcome::kInfeasible) << k;
  }
}

TEST(DualQp, goesOnFromACopyAfterTightening) {
  std::mt19937 random(5);
  for (int k = 0; k < 200; ++k) {
    const int n = 4;
    const int m = 10;
    QpProblem problem = makeConvex(n, m, true, random);
    View view(problem);
    DualQp parent(n, m), child(n, m), fresh(n, m);
    ASSERT_TRUE(parent.start(problem.G, problem.g));
    ASSERT_EQ(parent.minimise(view.rows(), view.limits, kInfinity), DualQp::Outcome::kOptimal);
    if (parent.x()(0) > view.limits.upper(m) - 1e-6) continue;
    view.limits.upper(m) = parent.x()(0) - 0.01;
    child.copy(parent);
    ASSERT_TRUE(fresh.start(problem.G, problem.g));
    const DualQp::Outcome outcome = fresh.minimise(view.rows(), view.limits, kInfinity);
    ASSERT_EQ(child.minimise(view.rows(), view.limits, kInfinity), outcome);
    if (outcome != DualQp::Outcome::kOptimal) continue;
    EXPECT_NEAR(child.value(), fresh.value(), 1e-8 * (1 + std::abs(fresh.value())));
    EXPECT_GE(child.value(), parent.value());
    EXPECT_EQ(parent.unknowns(), n);
  }
}

// As down a tree: one after another, what is open is closed, and unknowns come and go at their limits.
TEST(DualQp, goesOnThroughManyTightenings) {
  std::mt19937 random(7);
  int tightened = 0, held = 0;
  for (int k = 0; k < 100; ++k) {
    const int n = 12, m = 8;
    const QpProblem problem = makeConvex(n, m, true, random);
    View view(problem);
    view.limits.lower.setZero();
    view.limits.upper.setConstant(kInfinity);
    view.map.rightCols(1).setConstant(1);
    DualQp node(n, m), child(n, m);
    ASSERT_TRUE(node.start(problem.G, problem.g, std::vector<char>(n, 1)));
    for (int depth = 0; depth < n; ++depth) {
      DualQp fresh(n, m);
      ASSERT_TRUE(fresh.start(problem.G, problem.g));
      const DualQp::Outcome outcome = fresh.minimise(view.rows(), view.limits, kInfinity);
      ASSERT_EQ(node.minimise(view.rows(), view.limits, kInfinity), outcome) << k << " " << depth;
      if (outcome != DualQp::Outcome::kOptimal) break;
      EXPECT_NEAR(node.value(), fresh.value(), 1e-8 * (1 + std::abs(fresh.value()))) << k << " " << depth;
      EXPECT_LE((node.x() - fresh.x()).norm(), 1e-7 * (1 + fresh.x().norm())) << k << " " << depth;
      for (int i = 0; i < n; ++i) held += node.isHeld(i) ? 1 : 0;
      VecX values(m + n);
      values << node.rowValues(), node.x();
      const int limit = static_cast<int>(random() % static_cast<unsigned>(m + n));
      if (!(values(limit) > 0.01)) continue;
      view.limits.upper(limit) = 0;
      ++tightened;
      child.copy(node);
      std::swap(node, child);
    }
  }
  EXPECT_GT(tightened, 100);
  EXPECT_GT(held, 1000);
}

TEST(DualQp, stopsAtTheCutoff) {
  const MatX G = MatX::Identity(1, 1);
  const VecX g = VecX::Zero(1);
  const MatX map(0, 2);
  QpLimits limits(1);
  limits.lower << 2;
  limits.upper << kInfinity;
  DualQp qp(1, 0);
  ASSERT_TRUE(qp.start(G, g));
  EXPECT_EQ(qp.minimise(makeQpRows(map, 0), limits, 1), DualQp::Outcome::kCutOff);
  EXPECT_DOUBLE_EQ(qp.value(), 2);
}

TEST(DualQp, refusesAFlatObjective) {
  DualQp qp(2, 0);
  EXPECT_FALSE(qp.start(MatX::Ones(2, 2), VecX::Zero(2)));
}

}  // namespace
}  // namespace sinew
