#include "sinew/inverse/forward_problem.h"

#include <gtest/gtest.h>

#include <random>

namespace sinew {
namespace {

struct Case {
  MatX W;
  VecX displacement, effort, effort_min;
  Actuation actuation;
};

class ForwardProblemTest : public testing::Test {
 protected:
  std::mt19937 random{1};

  double uniform(double min, double max) { return std::uniform_real_distribution<double>(min, max)(random); }

  /// A compliance of `rank`, in m/N of soft robots, with more rows than actuators.
  Case makeCase(int actuators, int rank) {
    MatX root(actuators + 2, rank);
    for (int k = 0; k < root.size(); ++k) root(k / rank, k % rank) = uniform(-1, 1);
    Case c;
    c.W = 1e-3 * root * root.transpose();
    c.displacement.resize(actuators);
    c.effort.resize(actuators);
    c.effort_min.resize(actuators);
    c.actuation.value.resize(actuators);
    for (int i = 0; i < actuators; ++i) {
      c.displacement[i] = uniform(-0.01, 0.01);
      c.effort_min[i] = uniform(0, 1);
      c.effort[i] = c.effort_min[i] + uniform(0, 3);
      const bool given = random() % 3 == 0;
      c.actuation.mode.push_back(given ? Actuation::Mode::kEffort : Actuation::Mode::kDisplacement);
      c.actuation.value[i] = given ? uniform(0, 5) : uniform(-0.01, 0.01);
    }
    return c;
  }

  static void expectComplementarity(const Case& c, const VecX& change) {
    const Eigen::Index n = c.effort.size();
    const VecX displacement = c.displacement + c.W.topLeftCorner(n, n) * change;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double effort = c.effort[i] + change[i];
      if (c.actuation.mode[static_cast<std::size_t>(i)] == Actuation::Mode::kEffort) {
        EXPECT_NEAR(effort, c.actuation.value[i], 1e-12);
        continue;
      }
      const double spare = effort - c.effort_min[i], excess = displacement[i] - c.actuation.value[i];
      EXPECT_GT(spare, -1e-12);
      EXPECT_GT(excess, -1e-10);
      EXPECT_LT(std::min(spare, excess / 1e-3), 1e-7) << spare << " N, " << excess << " m";
    }
  }
};

TEST_F(ForwardProblemTest, EveryCableIsTautAtItsLengthOrSlack) {
  int taut = 0, slack = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const int actuators = 1 + static_cast<int>(random() % 8);
    const Case c = makeCase(actuators, actuators + 2);
    ForwardProblem problem(c.effort_min);
    VecX change(actuators);
    ASSERT_EQ(problem.solve(c.W, c.displacement, c.effort, c.actuation, change), QpStatus::kSolved);
    expectComplementarity(c, change);
    for (int i = 0; i < actuators; ++i) {
      if (c.actuation.mode[i] == Actuation::Mode::kEffort) continue;
      ++(c.effort[i] + change[i] > c.effort_min[i] + 1e-9 ? taut : slack);
    }
  }
  EXPECT_GT(taut, 300);
  EXPECT_GT(slack, 300);
}

// Cables that cannot be moved apart: lengths that exclude each other leave no answer, lengths that agree have one.
TEST_F(ForwardProblemTest, TakesARedundantCompliance) {
  for (int trial = 0; trial < 200; ++trial) {
    Case c = makeCase(4, 2);
    VecX reached = VecX::Zero(4);
    for (int i = 0; i < 4; ++i) reached[i] = c.effort_min[i] + uniform(0, 2) - c.effort[i];
    const VecX lengths = c.displacement + c.W.topLeftCorner(4, 4) * reached;
    for (int i = 0; i < 4; ++i) {
      const bool given = c.actuation.mode[i] == Actuation::Mode::kEffort;
      c.actuation.value[i] = given ? c.effort[i] + reached[i] : lengths[i];
    }
    ForwardProblem problem(c.effort_min);
    VecX change(4);
    ASSERT_EQ(problem.solve(c.W, c.displacement, c.effort, c.actuation, change), QpStatus::kSolved);
    expectComplementarity(c, change);
  }
}

TEST_F(ForwardProblemTest, RefusesWhatIsNoNumberAndRecovers) {
  const Case good = makeCase(3, 5);
  ForwardProblem problem(good.effort_min);
  VecX change = VecX::Constant(3, 7);
  for (double bad : {std::nan(""), 0.0}) {
    Case c = good;
    c.W(1, 1) = bad;
    EXPECT_EQ(problem.solve(c.W, c.displacement, c.effort, c.actuation, change), QpStatus::kNotFinite);
  }
  Case c = good;
  c.actuation.value[1] = std::nan("");
  EXPECT_NE(problem.solve(c.W, c.displacement, c.effort, c.actuation, change), QpStatus::kSolved);
  EXPECT_EQ(change, VecX::Constant(3, 7));
  ASSERT_EQ(problem.solve(good.W, good.displacement, good.effort, good.actuation, change), QpStatus::kSolved);
  expectComplementarity(good, change);
}

}  // namespace
}  // namespace sinew
