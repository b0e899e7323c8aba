#include "sinew/inverse/inverse_problem.h"

#include <gtest/gtest.h>

#include <random>

#include "inverse/brute_force_qp.h"

namespace sinew {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

/// Numbers of order one: the problem scales itself.
struct Case {
  InverseProblemData data;
  CycleLimits limits;

  Case(int actuators, int rows) : data(actuators, rows, 0), limits(actuators) {
    data.effector_rows = rows;
    data.effort.setZero();
    data.displacement.setZero();
    limits.effort_min.setConstant(-kFree);
    limits.effort_max.setConstant(kFree);
    limits.displacement_min.setConstant(-kFree);
    limits.displacement_max.setConstant(kFree);
  }
};

class InverseProblemTest : public testing::Test {
 protected:
  std::mt19937 random{1};

  double uniform(double min, double max) { return std::uniform_real_distribution<double>(min, max)(random); }

  MatX makeRandom(int rows, int columns) {
    MatX matrix(rows, columns);
    for (int c = 0; c < columns; ++c) {
      for (int r = 0; r < rows; ++r) matrix(r, c) = uniform(-1, 1);
    }
    return matrix;
  }

  /// Limits around the present state, so that the problem is feasible.
  Case makeCase(int actuators, int rows) {
    Case c(actuators, rows);
    const MatX root = makeRandom(actuators, actuators + 1);
    c.data.W_aa = root * root.transpose() + 0.05 * MatX::Identity(actuators, actuators);
    c.data.unit_compliance = c.data.W_aa.diagonal();
    c.data.W_ea = makeRandom(rows, actuators);
    c.data.effector_error = makeRandom(rows, 1);
    for (int i = 0; i < actuators; ++i) {
      c.data.effort[i] = uniform(0, 2);
      c.data.displacement[i] = uniform(-1, 1);
      c.limits.effort_min[i] = c.data.effort[i] - uniform(0, 0.5);
      c.limits.effort_max[i] = c.data.effort[i] + uniform(0, 0.5);
      c.limits.displacement_min[i] = c.data.displacement[i] - uniform(0, 0.5);
      c.limits.displacement_max[i] = c.data.displacement[i] + uniform(0, 0.5);
    }
    return c;
  }
};

InverseProblemResult solve(const Case& c) {
  const int actuators = static_cast<int>(c.data.effort.size());
  InverseProblem problem(actuators, static_cast<int>(c.data.W_ea.rows()), 0);
  InverseProblemResult result(actuators);
  EXPECT_EQ(problem.solve(c.data, c.limits, result), result.status);
  return result;
}

double calcError(const Case& c, const VecX& change) {
  return (c.data.effector_error + c.data.W_ea * change).norm();
}

double calcEnergy(const Case& c, const VecX& change) {
  const VecX effort = c.data.effort + change;
  return 0.5 * effort.dot(c.data.W_aa * effort);
}

BruteForceQp makeLimits(const Case& c) {
  const Eigen::Index n = c.data.effort.size();
  BruteForceQp qp;
  qp.A.resize(4 * n, n);
  qp.A << MatX::Identity(n, n), -MatX::Identity(n, n), c.data.W_aa, -c.data.W_aa;
  qp.b.resize(4 * n);
  qp.b << c.limits.effort_min - c.data.effort, c.data.effort - c.limits.effort_max,
      c.limits.displacement_min - c.data.displacement, c.data.displacement - c.limits.displacement_max;
  qp.E.resize(0, n);
  qp.f.resize(0);
  return qp;
}

/// Least error first, then least energy at that error.
VecX solveBruteForce(const Case& c) {
  BruteForceQp qp = makeLimits(c);
  qp.G = c.data.W_ea.transpose() * c.data.W_ea;
  qp.g = c.data.W_ea.transpose() * c.data.effector_error;
  const BruteForceQp::Answer nearest = qp.solve();
  EXPECT_TRUE(nearest.feasible);
  qp.E = c.data.W_ea;
  qp.f = c.data.W_ea * nearest.x;
  qp.G = c.data.W_aa;
  qp.g = c.data.W_aa * c.data.effort;
  return qp.solve().x;
}

void expectWithinLimits(const Case& c, const VecX& change) {
  EXPECT_LT((makeLimits(c).b - makeLimits(c).A * change).maxCoeff(), 1e-8);
}

TEST_F(InverseProblemTest, FindsWhatTryingEveryActiveSetFinds) {
  for (int trial = 0; trial < 300; ++trial) {
    const int actuators = 1 + static_cast<int>(random() % 3), rows = 1 + static_cast<int>(random() % 4);
    const Case c = makeCase(actuators, rows);
    const InverseProblemResult result = solve(c);
    ASSERT_EQ(result.status, QpStatus::kSolved) << "trial " << trial;
    const VecX expected = solveBruteForce(c);
    expectWithinLimits(c, result.effort_change);
    EXPECT_EQ(result.effort_violation.maxCoeff(), 0);
    EXPECT_NEAR(calcError(c, result.effort_change), calcError(c, expected), 1e-7) << "trial " << trial;
    EXPECT_NEAR(calcEnergy(c, result.effort_change), calcEnergy(c, expected), 1e-5) << "trial " << trial;
    EXPECT_LT((result.effort_change - expected).norm(), 1e-3) << "trial " << trial;
  }
}

// Without limits both levels have closed forms: d = -pinv(E) e + N y, y the least energy in the null space N.
TEST_F(InverseProblemTest, SpendsFreedomOnEnergyOnlyAfterTheError) {
  for (int trial = 0; trial < 50; ++trial) {
    Case c = makeCase(6, 3);
    c.limits = Case(6, 3).limits;
    const InverseProblemResult result = solve(c);
    ASSERT_EQ(result.status, QpStatus::kSolved);
    EXPECT_LT(calcError(c, result.effort_change), 1e-7);
    const MatX null = Eigen::FullPivLU<MatX>(c.data.W_ea).kernel();
    const VecX slope = null.transpose() * c.data.W_aa * (c.data.effort + result.effort_change);
    EXPECT_LT(slope.norm(), 1e-6 * null.norm());
  }
}

TEST_F(InverseProblemTest, WithoutEffectorsGoesToLeastEnergy) {
  Case c = makeCase(3, 2);
  c.limits = Case(3, 2).limits;
  c.data.effector_rows = 0;
  const InverseProblemResult result = solve(c);
  ASSERT_EQ(result.status, QpStatus::kSolved);
  EXPECT_LT((c.data.effort + result.effort_change).norm(), 1e-6);
}

// Limits of m and N that differ by many orders: the answer must scale with the units.
TEST_F(InverseProblemTest, DoesNotDependOnTheUnits) {
  for (int trial = 0; trial < 50; ++trial) {
    const Case c = makeCase(3, 2);
    Case other = c;
    const double metre = 1e-4, newton = 1e3;
    other.data.W_aa *= metre / newton;
    other.data.unit_compliance *= metre / newton;
    other.data.W_ea *= metre / newton;
    for (VecX* length : {&other.data.effector_error, &other.data.displacement, &other.limits.displacement_min,
                         &other.limits.displacement_max}) {
      *length *= metre;
    }
    for (VecX* force : {&other.data.effort, &other.limits.effort_min, &other.limits.effort_max}) *force *= newton;
    const VecX expected = solve(c).effort_change;
    EXPECT_LT((solve(other).effort_change / newton - expected).norm(), 1e-5);
  }
}

// One cable's displacement asks for more than the efforts allow. In z = sqrt(W_ii) effort its row r of unit diagonal
// reaches the limit when every effort gives way along r: t = |r| gap / |r|^2, gap what is missing with all at a limit.
TEST_F(InverseProblemTest, EffortsGiveWayByTheLeastViolation) {
  constexpr int kActuators = 3;
  for (int trial = 0; trial < 50; ++trial) {
    Case c = makeCase(kActuators, 2);
    c.limits.displacement_min.setConstant(-kFree);
    c.limits.displacement_max.setConstant(kFree);
    const VecX scale = c.data.W_aa.diagonal().cwiseSqrt();
    const VecX row = c.data.W_aa.row(0).transpose().cwiseQuotient(scale) / scale[0];
    double reach = 0;
    for (int i = 0; i < kActuators; ++i) {
      const double at = row[i] > 0 ? c.limits.effort_max[i] : c.limits.effort_min[i];
      reach += row[i] * scale[i] * (at - c.data.effort[i]);
    }
    const double gap = 0.3;
    c.limits.displacement_min[0] = c.data.displacement[0] + scale[0] * (reach + gap);
    const InverseProblemResult result = solve(c);
    ASSERT_EQ(result.status, QpStatus::kSolved);
    const VecX expected = (gap / row.squaredNorm() * row.cwiseAbs()).cwiseQuotient(scale);
    EXPECT_LT((result.effort_violation - expected).norm(), 1e-5 * expected.norm());
    const double displacement = c.data.displacement[0] + c.data.W_aa.row(0).dot(result.effort_change);
    EXPECT_NEAR(displacement, c.limits.displacement_min[0], 1e-6);
  }
}

TEST_F(InverseProblemTest, DisplacementLimitsNeverGiveWay) {
  Case c = makeCase(2, 2);
  c.limits.displacement_min = c.data.displacement.array() + 0.5;
  c.limits.displacement_max = c.data.displacement.array() + 0.6;
  c.limits.effort_min = c.data.effort;
  c.limits.effort_max = c.data.effort;
  const InverseProblemResult result = solve(c);
  ASSERT_EQ(result.status, QpStatus::kSolved);
  EXPECT_GT(result.effort_violation.maxCoeff(), 0.01);
  const VecX displacement = c.data.displacement + c.data.W_aa * result.effort_change;
  EXPECT_GE((displacement - c.limits.displacement_min).minCoeff(), -1e-9);
  EXPECT_LE((displacement - c.limits.displacement_max).maxCoeff(), 1e-9);
}

TEST_F(InverseProblemTest, RefusesWhatIsNoNumberAndRecovers) {
  const Case good = makeCase(3, 2);
  InverseProblem problem(3, 2, 0);
  InverseProblemResult result(3);
  for (double bad : {std::nan(""), kFree, 0.0}) {
    Case c = good;
    c.data.W_aa(1, 1) = c.data.unit_compliance[1] = bad;
    EXPECT_NE(problem.solve(c.data, c.limits, result), QpStatus::kSolved);
  }
  Case c = good;
  c.data.effector_error[0] = std::nan("");
  EXPECT_NE(problem.solve(c.data, c.limits, result), QpStatus::kSolved);
  ASSERT_EQ(problem.solve(good.data, good.limits, result), QpStatus::kSolved);
  EXPECT_LT((result.effort_change - solve(good).effort_change).norm(), 1e-6);
}

TEST_F(InverseProblemTest, DampingShortensTheChange) {
  for (int trial = 0; trial < 20; ++trial) {
    Case c = makeCase(3, 3);
    c.limits = Case(3, 3).limits;
    double before = solve(c).effort_change.cwiseProduct(c.data.W_aa.diagonal().cwiseSqrt()).norm();
    for (double damping : {0.1, 1.0, 10.0}) {
      c.data.damping = damping;
      const double now = solve(c).effort_change.cwiseProduct(c.data.W_aa.diagonal().cwiseSqrt()).norm();
      EXPECT_LT(now, before);
      before = now;
    }
  }
}

// A gain too small to matter is left: the error stays where it is, whatever the energy does.
TEST_F(InverseProblemTest, LeavesANegligibleGain) {
  Case c = makeCase(3, 2);
  c.data.effector_error *= 1e-6 / c.data.effector_error.norm();
  EXPECT_LT(calcError(c, solve(c).effort_change), 1e-7);
  c.data.negligible_gain = 1e-5;
  EXPECT_NEAR(calcError(c, solve(c).effort_change), 1e-6, 1e-9);
}

}  // namespace
}  // namespace sinew
