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

  /// A compliance of `rank`, in m/N of soft robots, with `others` more rows than actuators.
  Case makeCase(int actuators, int rank, int others = 2) {
    MatX root(actuators + others, rank);
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

QpStatus solve(const Case& c, ForwardProblem& problem, VecX& change) {
  const int actuators = static_cast<int>(c.effort.size());
  const QpStatus status = problem.solve(c.W, actuators, c.displacement, VecX(), c.effort, c.actuation);
  if (status == QpStatus::kSolved) change = problem.effortChange();
  return status;
}

TEST_F(ForwardProblemTest, EveryCableIsTautAtItsLengthOrSlack) {
  int taut = 0, slack = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const int actuators = 1 + static_cast<int>(random() % 8);
    const Case c = makeCase(actuators, actuators + 2);
    ForwardProblem problem(c.effort_min, 0);
    VecX change(actuators);
    ASSERT_EQ(solve(c, problem, change), QpStatus::kSolved);
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
    ForwardProblem problem(c.effort_min, 0);
    VecX change(4);
    ASSERT_EQ(solve(c, problem, change), QpStatus::kSolved);
    expectComplementarity(c, change);
  }
}

TEST_F(ForwardProblemTest, RefusesWhatIsNoNumberAndRecovers) {
  const Case good = makeCase(3, 5);
  ForwardProblem problem(good.effort_min, 0);
  VecX change = VecX::Constant(3, 7);
  for (double bad : {std::nan(""), 0.0}) {
    Case c = good;
    c.W(1, 1) = bad;
    EXPECT_EQ(solve(c, problem, change), QpStatus::kNotFinite);
  }
  Case c = good;
  c.actuation.value[1] = std::nan("");
  EXPECT_NE(solve(c, problem, change), QpStatus::kSolved);
  EXPECT_EQ(change, VecX::Constant(3, 7));
  ASSERT_EQ(solve(good, problem, change), QpStatus::kSolved);
  expectComplementarity(good, change);
}

// Signorini's law beside the cables', with the effectors' rows in between; half of the contacts double another one.
TEST_F(ForwardProblemTest, ContactsPressOrStandOff) {
  int pressing = 0, apart = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const int actuators = 1 + static_cast<int>(random() % 4), contacts = 2 * (1 + static_cast<int>(random() % 5));
    const int first = actuators + 3;
    Case c = makeCase(actuators, first + contacts + 2, 3 + contacts);
    MatX& W = c.W;
    VecX gap(contacts);
    for (int i = 0; i < contacts; ++i) gap[i] = 1e-3 * uniform(-1, 1);
    for (int i = 0; i < contacts; i += 2) {
      W.row(first + i + 1) = W.row(first + i).eval();
      W.col(first + i + 1) = W.col(first + i).eval();
      gap[i + 1] = gap[i];
    }
    ForwardProblem problem(c.effort_min, contacts);
    ASSERT_EQ(problem.solve(W, first, c.displacement, gap, c.effort, c.actuation), QpStatus::kSolved);
    const VecX change = problem.effortChange(), force = problem.contactForce();
    VecX cables = c.displacement;
    cables += W.block(0, first, actuators, contacts) * force;
    Case pushed = c;
    pushed.displacement = cables;
    expectComplementarity(pushed, change);
    const VecX apart_by =
        gap + W.block(first, 0, contacts, actuators) * change + W.block(first, first, contacts, contacts) * force;
    for (int i = 0; i < contacts; ++i) {
      EXPECT_GE(force[i], 0);
      EXPECT_GE(apart_by[i], -1e-9);
      EXPECT_LT(std::min(force[i], apart_by[i] / 1e-3), 1e-5) << force[i] << " N, " << apart_by[i] << " m";
      ++(force[i] > 1e-6 ? pressing : apart);
    }
  }
  EXPECT_GT(pressing, 300);
  EXPECT_GT(apart, 300);
}

}  // namespace
}  // namespace sinew
