#include "sinew/inverse/forward_problem.h"

#include <gtest/gtest.h>

#include <random>

#include "sinew/robot/robot_description.h"

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
      EXPECT_GT(excess, -1e-13);
      EXPECT_LT(std::min(spare, excess / 1e-3), 1e-10) << spare << " N, " << excess << " m";
    }
  }
};

QpStatus solve(const Case& c, ForwardProblem& problem, VecX& change) {
  const int actuators = static_cast<int>(c.effort.size());
  const QpStatus status = problem.solve(c.W, actuators, c.displacement, VecX(), c.effort, c.actuation, VecX());
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
    ASSERT_EQ(problem.solve(W, first, c.displacement, gap, c.effort, c.actuation, VecX::Zero(contacts)),
              QpStatus::kSolved);
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
      EXPECT_GE(apart_by[i], -1e-13);
      EXPECT_LE(std::abs(force[i] * apart_by[i]), 1e-12 * force.maxCoeff() * gap.cwiseAbs().maxCoeff());
      EXPECT_NEAR(problem.contactGap()[i], apart_by[i], 1e-14);
      ++(force[i] > 1e-6 ? pressing : apart);
    }
  }
  EXPECT_GT(pressing, 300);
  EXPECT_GT(apart, 300);
}

/// The equivalent QP, efforts in changes: min 1/2 f^T W f + f^T level within the bounds.
VecX solveAsQp(const MatX& W, const VecX& level, const VecX& lower, const VecX& upper) {
  const int size = static_cast<int>(level.size());
  QpProblem problem(size, 0);
  problem.G = W;
  problem.g = level;
  problem.lower = lower;
  problem.upper = upper;
  QpSolution solution(size, 0);
  DenseQp qp(size, 0);
  EXPECT_EQ(qp.solve(problem, solution), QpStatus::kSolved);
  return solution.x;
}

TEST_F(ForwardProblemTest, AgreesWithTheQp) {
  for (int trial = 0; trial < 300; ++trial) {
    const int actuators = 1 + static_cast<int>(random() % 8), contacts = static_cast<int>(random() % 30);
    const int size = actuators + contacts;
    Case c = makeCase(actuators, size + 2, contacts);
    VecX level(size), lower = VecX::Zero(size), upper = VecX::Constant(size, kUnlimited);
    for (int i = 0; i < contacts; ++i) level[actuators + i] = 1e-3 * uniform(-1, 1);
    for (int i = 0; i < actuators; ++i) {
      const bool given = c.actuation.mode[i] == Actuation::Mode::kEffort;
      level[i] = c.displacement[i] - (given ? 0 : c.actuation.value[i]);
      lower[i] = (given ? c.actuation.value[i] : c.effort_min[i]) - c.effort[i];
      if (given) upper[i] = lower[i];
    }
    ForwardProblem problem(c.effort_min, contacts);
    const VecX gap = level.tail(contacts), guess = VecX::Constant(contacts, uniform(0, 1));
    ASSERT_EQ(problem.solve(c.W, actuators, c.displacement, gap, c.effort, c.actuation, guess), QpStatus::kSolved);
    VecX found(size);
    found << problem.effortChange(), problem.contactForce();
    EXPECT_LT((c.W * (found - solveAsQp(c.W, level, lower, upper))).cwiseAbs().maxCoeff(), 1e-9) << "m";
  }
}

TEST_F(ForwardProblemTest, AllCablesHangSlackAndNothingTouches) {
  Case c = makeCase(6, 12, 10);
  c.actuation.mode.assign(6, Actuation::Mode::kDisplacement);
  c.effort = c.effort_min;
  c.displacement.setConstant(0.01);
  c.actuation.value.setZero();
  ForwardProblem problem(c.effort_min, 10);
  const VecX gap = VecX::Constant(10, 0.002), guess = VecX::Ones(10);
  ASSERT_EQ(problem.solve(c.W, 6, c.displacement, gap, c.effort, c.actuation, guess), QpStatus::kSolved);
  EXPECT_EQ(VecX(problem.effortChange()), VecX::Zero(6));
  EXPECT_EQ(VecX(problem.contactForce()), VecX::Zero(10));
  EXPECT_EQ(VecX(problem.contactGap()), gap);
}

// A row without a least effort is where it is told to be, by whatever force that takes.
TEST_F(ForwardProblemTest, WhatPushesAsWellAsItPullsIsHeld) {
  int pushed = 0;
  for (int trial = 0; trial < 100; ++trial) {
    Case c = makeCase(3, 9, 4);
    c.actuation.mode[2] = Actuation::Mode::kDisplacement;
    c.effort_min[2] = -kUnlimited;
    c.effort[2] = uniform(-1, 1);
    ForwardProblem problem(c.effort_min, 4);
    const VecX gap = VecX::Constant(4, -0.001);
    ASSERT_EQ(problem.solve(c.W, 3, c.displacement, gap, c.effort, c.actuation, VecX::Zero(4)), QpStatus::kSolved);
    VecX found(7);
    found << problem.effortChange(), problem.contactForce();
    EXPECT_NEAR(c.displacement[2] + c.W.row(2).dot(found), c.actuation.value[2], 1e-13);
    pushed += c.effort[2] + found[2] < 0;
  }
  EXPECT_GT(pushed, 20);
}

// Two walls that leave a body no room: there is an answer, and it is the one in the middle.
TEST_F(ForwardProblemTest, AnswersWhereThereIsNoRoom) {
  Case c = makeCase(2, 8, 2);
  c.actuation.mode.assign(2, Actuation::Mode::kEffort);
  c.actuation.value = c.effort;
  c.W.row(3) = -c.W.row(2).eval();
  c.W.col(3) = -c.W.col(2).eval();
  ForwardProblem problem(c.effort_min, 2);
  const VecX gap = VecX::Constant(2, -0.001);
  ASSERT_EQ(problem.solve(c.W, 2, c.displacement, gap, c.effort, c.actuation, VecX::Zero(2)), QpStatus::kSolved);
  EXPECT_GT(problem.contactForce().minCoeff(), 0);
  EXPECT_NEAR(problem.contactGap()[0], problem.contactGap()[1], 1e-6);
}

}  // namespace
}  // namespace sinew
