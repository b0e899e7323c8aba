#include "sinew/solver/complementarity_gauss_seidel.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <limits>
#include <random>

#include "allocation_count.h"
#include "sinew/solver/dense_qp.h"

namespace sinew {
namespace {

using Status = ComplementarityStatus;

class ComplementarityGaussSeidelTest : public testing::Test {
 protected:
  std::mt19937 random{1};

  double uniform(double min, double max) { return std::uniform_real_distribution<double>(min, max)(random); }
  VecX makeVector(int size) {
    return VecX::NullaryExpr(size, [this](Eigen::Index) { return uniform(-1, 1); });
  }

  /// A of `rank`, scaled to a unit diagonal.
  ComplementarityProblem makeProblem(int size, int rank) {
    MatX root(size, rank);
    for (int i = 0; i < size; ++i) root.row(i) = makeVector(rank).normalized();
    ComplementarityProblem problem(size);
    problem.size = size;
    problem.A = root * root.transpose();
    problem.b = makeVector(size);
    return problem;
  }

  /// b such that an answer exists, with rows that press, that are apart, and that just touch.
  void makeSolvable(ComplementarityProblem& problem) {
    VecX x(problem.size), gap(problem.size);
    for (int i = 0; i < problem.size; ++i) {
      const auto kind = random() % 3;
      x[i] = kind == 0 ? uniform(0, 1) : 0;
      gap[i] = kind == 1 ? uniform(0, 1) : 0;
      if (problem.equality[i]) x[i] = uniform(-1, 1), gap[i] = 0;
    }
    problem.b = gap - problem.A * x;
  }

  static void expectLaw(const ComplementarityProblem& problem, const VecX& x, double tolerance) {
    const VecX value = problem.A * x + problem.b;
    const double largest = problem.b.cwiseAbs().maxCoeff(), most = std::max(x.cwiseAbs().maxCoeff(), 1e-300);
    for (int i = 0; i < problem.size; ++i) {
      EXPECT_LE(std::abs(x[i] * value[i]), tolerance * most * largest) << i;
      if (problem.equality[i]) {
        EXPECT_LE(std::abs(value[i]), tolerance * largest) << i;
      } else {
        EXPECT_GE(x[i], 0) << i;
        EXPECT_GE(value[i], -tolerance * (largest + most)) << i;
      }
    }
  }

  /// A x + b, which is unique, by trying every set of active rows.
  static VecX enumerate(const ComplementarityProblem& problem) {
    for (unsigned set = 0; set < 1U << problem.size; ++set) {
      std::vector<int> active;
      for (int i = 0; i < problem.size; ++i) {
        if (set >> i & 1U) active.push_back(i);
      }
      const Eigen::Index n = static_cast<Eigen::Index>(active.size());
      MatX A(n, n);
      VecX b(n);
      for (Eigen::Index i = 0; i < n; ++i) {
        b[i] = problem.b[active[i]];
        for (Eigen::Index j = 0; j < n; ++j) A(i, j) = problem.A(active[i], active[j]);
      }
      const VecX pressing = n > 0 ? VecX(A.completeOrthogonalDecomposition().solve(-b)) : VecX();
      VecX x = VecX::Zero(problem.size);
      for (Eigen::Index i = 0; i < n; ++i) x[active[i]] = pressing[i];
      const VecX value = problem.A * x + problem.b;
      bool holds = true;
      for (int i = 0; i < problem.size; ++i) {
        const bool zero = std::abs(value[i]) <= 1e-9;
        holds = holds && (problem.equality[i] ? zero : x[i] >= -1e-9 && value[i] >= -1e-9 && (x[i] <= 1e-9 || zero));
      }
      if (holds) return value;
    }
    return VecX();
  }

  static VecX solveAsQp(const ComplementarityProblem& problem) {
    QpProblem qp(problem.size, 0);
    qp.G = problem.A + ComplementarityGaussSeidel::kLift * MatX::Identity(problem.size, problem.size);
    qp.g = problem.b;
    for (int i = 0; i < problem.size; ++i) {
      qp.lower[i] = problem.equality[i] ? -std::numeric_limits<double>::infinity() : 0.0;
    }
    QpSolution solution(problem.size, 0);
    DenseQp solver(problem.size, 0);
    EXPECT_EQ(solver.solve(qp, solution), QpStatus::kSolved);
    return solution.x;
  }
};

TEST_F(ComplementarityGaussSeidelTest, FindsWhatEnumerationFinds) {
  ComplementarityGaussSeidel solver(7);
  for (int trial = 0; trial < 300; ++trial) {
    const int size = 1 + static_cast<int>(random() % 7);
    ComplementarityProblem problem = makeProblem(size, 1 + static_cast<int>(random() % 9));
    problem.block = static_cast<int>(random() % static_cast<unsigned>(size + 1));
    for (int i = 0; i < size; ++i) problem.equality[i] = random() % 5 == 0;
    makeSolvable(problem);
    VecX x = makeVector(size);
    ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
    expectLaw(problem, x, 1e-12);
    const VecX value = enumerate(problem);
    ASSERT_EQ(value.size(), size) << "the test's own enumeration";
    EXPECT_LT((solver.value() - value).cwiseAbs().maxCoeff(), 1e-8);
  }
}

// Robots' sizes: rows of cables in front, many contacts behind, up to three times as many as the rank.
TEST_F(ComplementarityGaussSeidelTest, FindsWhatTheQpFinds) {
  ComplementarityGaussSeidel solver(90);
  int most = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int size = 10 + static_cast<int>(random() % 81);
    ComplementarityProblem problem = makeProblem(size, size / 3 + static_cast<int>(random() % 90));
    problem.block = static_cast<int>(random() % 9);
    makeSolvable(problem);
    VecX x = VecX::Zero(size);
    ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
    expectLaw(problem, x, 1e-12);
    const VecX value = problem.A * solveAsQp(problem) + problem.b;
    EXPECT_LT((solver.value() - value).cwiseAbs().maxCoeff(), 1e-6);
    most = std::max(most, solver.directSolves());
  }
  EXPECT_LT(most, 100);
}

TEST_F(ComplementarityGaussSeidelTest, TakesTheSameRowTwice) {
  for (int trial = 0; trial < 200; ++trial) {
    ComplementarityProblem problem = makeProblem(12, 5);
    for (int i = 0; i < 12; i += 2) {
      problem.A.row(i + 1) = problem.A.row(i).eval();
      problem.A.col(i + 1) = problem.A.col(i).eval();
    }
    makeSolvable(problem);
    for (int i = 0; i < 12; i += 2) problem.b[i + 1] = problem.b[i] = std::max(problem.b[i], problem.b[i + 1]);
    ComplementarityGaussSeidel solver(12);
    VecX x = VecX::Zero(12);
    ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
    expectLaw(problem, x, 1e-12);
  }
}

// Rows that contradict each other, a body squeezed between two walls that leave it no room: forces without end, were
// it not for the lift. It still answers, and rows without contradiction come out as without the lift.
TEST_F(ComplementarityGaussSeidelTest, AlwaysAnswers) {
  for (int trial = 0; trial < 300; ++trial) {
    const int size = 2 + static_cast<int>(random() % 30);
    ComplementarityProblem problem = makeProblem(size, 1 + static_cast<int>(random() % 5));
    problem.A.row(1) = -problem.A.row(0).eval();
    problem.A.col(1) = -problem.A.col(0).eval();
    problem.b[0] = problem.b[1] = -uniform(0.1, 1);
    ComplementarityGaussSeidel solver(size);
    VecX x = VecX::Zero(size);
    ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
    for (int i = 0; i < size; ++i) EXPECT_GE(x[i], 0);
    const VecX lifted = solver.value() + ComplementarityGaussSeidel::kLift * x;
    EXPECT_GE(lifted.minCoeff(), -1e-6);
    EXPECT_LT((lifted.cwiseProduct(x)).cwiseAbs().maxCoeff(), 1e-6 * x.maxCoeff());
  }
}

TEST_F(ComplementarityGaussSeidelTest, NothingTouches) {
  ComplementarityProblem problem = makeProblem(20, 20);
  problem.b = problem.b.cwiseAbs();
  ComplementarityGaussSeidel solver(20);
  VecX x = VecX::Ones(20);
  ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
  EXPECT_EQ(x, VecX::Zero(20));
  EXPECT_EQ(VecX(solver.value()), problem.b);
  problem.size = 0;
  EXPECT_EQ(solver.solve(problem, x.head(0)), Status::kSolved);
}

TEST_F(ComplementarityGaussSeidelTest, TheLastAnswerIsAGoodStart) {
  ComplementarityProblem problem = makeProblem(60, 60);
  ComplementarityGaussSeidel solver(60);
  VecX x = VecX::Zero(60);
  ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
  const VecX cold = x;
  ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
  EXPECT_EQ(solver.directSolves(), 1);
  EXPECT_LT((x - cold).cwiseAbs().maxCoeff(), 1e-9 * cold.maxCoeff());
}

TEST_F(ComplementarityGaussSeidelTest, RefusesWhatIsNoNumberAndRecovers) {
  const ComplementarityProblem good = makeProblem(8, 8);
  ComplementarityGaussSeidel solver(8);
  for (double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    ComplementarityProblem problem = good;
    problem.b[3] = -bad;
    VecX x = VecX::Ones(8);
    EXPECT_NE(solver.solve(problem, x), Status::kSolved);
    EXPECT_EQ(x, VecX::Ones(8));
    problem = good;
    problem.A(3, 3) = problem.A(2, 3) = problem.A(3, 2) = bad;
    problem.b[3] = -1;
    EXPECT_NE(solver.solve(problem, x), Status::kSolved);
  }
  VecX x = VecX::Zero(8);
  ASSERT_EQ(solver.solve(good, x), Status::kSolved);
  expectLaw(good, x, 1e-12);
}

TEST_F(ComplementarityGaussSeidelTest, DoesNotAllocate) {
  const ComplementarityProblem problem = makeProblem(80, 60);
  ComplementarityGaussSeidel solver(80);
  VecX x = VecX::Zero(80);
  const long before = allocationCount();
  ASSERT_EQ(solver.solve(problem, x), Status::kSolved);
  EXPECT_EQ(allocationCount() - before, 0);
}

}  // namespace
}  // namespace sinew
