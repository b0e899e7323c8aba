#include "sinew/body/fem_body.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "body/energy.h"
#include "body/newton.h"
#include "check_line.h"
#include "fem/bar_model.h"

namespace sinew {
namespace {

const Vec3 kGravity(0, 0, -9.81);

BarModel makeSmallBar() {
  return BarModel(Vec3(0.1, 0.02, 0.02), 10, 2, 2, 2e5, 0.3, 1000);
}

VecX makeRandomForce(const FemModel& model, double size) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, size);
  VecX force(model.size());
  for (int i = 0; i < force.size(); ++i) force[i] = normal(random);
  return force;
}

/// One step with one linearisation, as a cycle makes it.
void takeStep(FemBody& body, const StepRule& rule) {
  VecX motion(body.model().size());
  body.beginStep();
  body.linearise(rule);
  ASSERT_TRUE(body.factorise());
  motion = body.load();
  body.cholesky().solve(motion);
  body.advance(motion, 1);
  body.endStep(rule);
}

TEST(FemBody, RestsWhereEveryForceAndMomentBalances) {
  const BarModel bar = makeSmallBar();
  FemBody body(bar.fem, kGravity);
  const VecX external = makeRandomForce(bar.fem, 2e-3);
  ASSERT_GE(settle(body, external, 1e-10), 0);
  std::vector<Vec3> forces = calcElasticForces(bar.fem, body.positions());
  Vec3 reaction = Vec3::Zero(), applied = Vec3::Zero(), moment = Vec3::Zero();
  for (int node = 0; node < bar.fem.nodeCount(); ++node) {
    const int free = bar.fem.freeIndex(node);
    if (free < 0) {
      reaction -= forces[node];
      moment -= body.positions()[node].cross(forces[node]);
      continue;
    }
    const Vec3 load = bar.fem.mass()[free] * kGravity + external.segment<3>(3 * free);
    EXPECT_LT((forces[node] + load).norm(), 1e-8);
    applied += load;
    moment += body.positions()[node].cross(load);
  }
  EXPECT_GT(applied.norm(), 0.3);
  EXPECT_LT((reaction + applied).norm(), 1e-8 * applied.norm());
  EXPECT_LT(moment.norm(), 1e-8);
}

TEST(FemBody, RestsWhereThePotentialIsStationary) {
  const BarModel bar = makeSmallBar();
  FemBody body(bar.fem, kGravity);
  const VecX external = makeRandomForce(bar.fem, 2e-3);
  ASSERT_GE(settle(body, external, 1e-10), 0);
  std::vector<Vec3> positions = body.positions();
  constexpr double kStep = 1e-6;  // m
  for (int free = 3; free < bar.fem.freeCount(); free += 17) {
    Vec3& position = positions[bar.fem.freeNodes()[free]];
    for (int axis = 0; axis < 3; ++axis) {
      const double at = position[axis];
      position[axis] = at + kStep;
      const double above = calcElasticEnergy(bar.fem, positions);
      position[axis] = at - kStep;
      const double below = calcElasticEnergy(bar.fem, positions);
      position[axis] = at;
      const double load = bar.fem.mass()[free] * kGravity[axis] + external[3 * free + axis];
      EXPECT_NEAR((above - below) / (2 * kStep), load, 1e-6);
    }
  }
}

TEST(FemBody, ImbalanceIsTheLoadOfAStaticBodyAndLeavesInertiaOut) {
  const BarModel bar = makeSmallBar();
  FemBody body(bar.fem, kGravity);
  body.beginStep();
  body.advance(makeRandomForce(bar.fem, 1e-4), 1);
  body.linearise(StepRule());
  const VecX imbalance = body.imbalance();
  EXPECT_EQ(imbalance, body.load());
  body.linearise({true, 0.01, 2, 0.02});
  EXPECT_LT((body.imbalance() - imbalance).norm(), 1e-12 * imbalance.norm());
  EXPECT_GT((body.load() - imbalance).norm(), imbalance.norm());
}

// The dynamic system against its own equation, with the stiffness of the static one.
TEST(FemBody, DynamicSystemIsThatOfBackwardEuler) {
  const BarModel bar = makeSmallBar();
  const StepRule rule{true, 0.01, 3, 0.02};
  FemBody body(bar.fem, kGravity);
  takeStep(body, rule);
  const VecX velocity = [&] {
    VecX v(bar.fem.size());
    for (int i = 0; i < bar.fem.freeCount(); ++i) {
      const int node = bar.fem.freeNodes()[i];
      v.segment<3>(3 * i) = (body.positions()[node] - bar.fem.rest()[node]) / rule.period;
    }
    return v;
  }();
  body.beginStep();
  const VecX way = makeRandomForce(bar.fem, 1e-4);
  body.advance(way, 1);

  body.linearise(StepRule());
  const MatX K = body.matrix().makeDense();
  const VecX force = body.load();
  MatX M = MatX::Zero(bar.fem.size(), bar.fem.size());
  for (int i = 0; i < bar.fem.size(); ++i) M(i, i) = bar.fem.mass()[i / 3];
  const MatX D = rule.damping_mass * M + rule.damping_stiffness * K;
  const double h = rule.period;
  const MatX A = K + D / h + M / (h * h);
  const VecX b = force + M * (velocity - way / h) / h - D * way / h;
  body.linearise(rule);
  EXPECT_LT((body.matrix().makeDense() - A).norm(), 1e-12 * A.norm());
  EXPECT_LT((body.load() - b).norm(), 1e-9 * b.norm());
}

TEST(FemBody, FallsFreelyInItsFirstInstant) {
  const BarModel bar(Vec3(0.1, 0.02, 0.02), 10, 2, 2, 1e4, 0.3, 1000);
  FemBody body(bar.fem, kGravity);
  const double h = 1e-6;
  takeStep(body, {true, h, 0, 0});
  takeStep(body, {true, h, 0, 0});
  for (int node : bar.fem.freeNodes()) {
    if (bar.fem.rest()[node].x() < 0.03) continue;
    const Vec3 fallen = body.positions()[node] - bar.fem.rest()[node];
    EXPECT_LT((fallen - 3 * h * h * kGravity).norm(), 1e-3 * 3 * h * h * kGravity.norm());
  }
}

double kineticEnergy(const FemModel& model, const std::vector<Vec3>& before, const std::vector<Vec3>& after, double h) {
  double energy = 0;
  for (int i = 0; i < model.freeCount(); ++i) {
    const int node = model.freeNodes()[i];
    energy += 0.5 * model.mass()[i] * (after[node] - before[node]).squaredNorm() / (h * h);
  }
  return energy;
}

TEST(FemBody, LosesEnergyInEveryDampedStep) {
  const BarModel bar = makeSmallBar();
  FemBody bent(bar.fem, Vec3(0, 5, -10));
  ASSERT_GE(settle(bent, VecX::Zero(bar.fem.size()), 1e-8), 0);
  FemBody body(bar.fem, Vec3::Zero());
  body.place(bent.positions());
  const StepRule rule{true, 0.002, 2, 0.01};
  const double first = calcElasticEnergy(bar.fem, body.positions());
  double energy = first;
  for (int k = 0; k < 100; ++k) {
    const std::vector<Vec3> before = body.positions();
    takeStep(body, rule);
    const double now =
        calcElasticEnergy(bar.fem, body.positions()) + kineticEnergy(bar.fem, before, body.positions(), rule.period);
    EXPECT_LT(now, energy) << "step " << k;
    energy = now;
  }
  EXPECT_LT(energy, 0.05 * first);
}

/// The slowest way to swing without damping, by inverse iteration.
struct Mode {
  double frequency;  ///< rad/s
  VecX shape;        ///< 10 um where it is largest, free nodes

  explicit Mode(const FemModel& model) : shape(VecX::Zero(model.size())) {
    FemBody body(model, Vec3::Zero());
    body.linearise(StepRule());
    EXPECT_TRUE(body.factorise());
    for (int i = 0; i < model.freeCount(); ++i) shape[3 * i + 2] = 1;
    for (int k = 0; k < 30; ++k) {
      VecX next = scaleByMass(model, shape);
      body.cholesky().solve(next);
      frequency = std::sqrt(project(model, shape) / scaleByMass(model, shape).dot(next));
      shape = next * (1e-5 / next.cwiseAbs().maxCoeff());
    }
  }

  double project(const FemModel& model, const VecX& way) const { return scaleByMass(model, shape).dot(way); }

 private:
  static VecX scaleByMass(const FemModel& model, const VecX& x) {
    VecX y(x.size());
    for (int i = 0; i < model.freeCount(); ++i) y.segment<3>(3 * i) = model.mass()[i] * x.segment<3>(3 * i);
    return y;
  }
};

/// Backward Euler moves a mode by  u+ - 2 u + u- = -a u+ - b (u+ - u),  a = (w h)^2, b = h (alpha + beta w^2): fitted
/// to a bar released from the bend of its first mode. Returns w [rad/s] and b / h [1/s].
std::pair<double, double> fitMode(const FemModel& model, const Mode& mode, const StepRule& rule) {
  constexpr int kSteps = 20;
  FemBody body(model, Vec3::Zero());
  std::vector<Vec3> bent = model.rest();
  for (int i = 0; i < model.freeCount(); ++i) bent[model.freeNodes()[i]] += mode.shape.segment<3>(3 * i);
  body.place(bent);
  VecX way(model.size());
  MatX u(kSteps, 1);
  for (int k = 0; k < kSteps; ++k) {
    takeStep(body, rule);
    for (int i = 0; i < model.freeCount(); ++i) {
      const int node = model.freeNodes()[i];
      way.segment<3>(3 * i) = body.positions()[node] - model.rest()[node];
    }
    u(k) = mode.project(model, way);
  }
  const VecX after = u.bottomRows(kSteps - 2), now = u.middleRows(1, kSteps - 2), before = u.topRows(kSteps - 2);
  MatX system(kSteps - 2, 2);
  system << after, after - now;
  const VecX fit = system.colPivHouseholderQr().solve(-(after - 2 * now + before));
  return {std::sqrt(fit[0]) / rule.period, fit[1] / rule.period};
}

/// Frequency of a clamped bar, swinging the thin way, over that of Euler and Bernoulli:
///   w = 1.8751^2 sqrt(E I / (rho A L^4)), I / A = height^2 / 12.
double relativeFrequency(int cells) {
  constexpr double kLength = 0.1, kHeight = 0.01, kYoungModulus = 1e6, kDensity = 1000;
  const BarModel bar(Vec3(kLength, 1.5 * kHeight, kHeight), 10 * cells, 2, cells, kYoungModulus, 0, kDensity);
  const double exact =
      1.8751 * 1.8751 / (kLength * kLength) * std::sqrt(kYoungModulus * kHeight * kHeight / (12 * kDensity));
  const Mode mode(bar.fem);
  const auto [frequency, damping] = fitMode(bar.fem, mode, {true, 2 * M_PI / exact / 200, 0, 0});
  EXPECT_NEAR(frequency, mode.frequency, 1e-3 * exact);
  EXPECT_NEAR(damping, 0, 1e-3 * exact);
  return frequency / exact;
}

// Linear tetrahedra bend too stiffly by an error that falls with the square of their size.
TEST(FemBody, SwingsAtTheFrequencyOfEulerAndBernoulli) {
  const double coarse = relativeFrequency(3), fine = relativeFrequency(6);
  checkFigure("cantilever.first_frequency_error", 100 * std::abs(fine + (fine - coarse) / 3 - 1), "<=", 3, "%");
  EXPECT_GT(coarse, fine);
  EXPECT_GT(fine, 1);
}

TEST(FemBody, DampsAModeAsRayleighSays) {
  const BarModel bar(Vec3(0.1, 0.02, 0.01), 12, 2, 2, 1e6, 0.3, 1000);
  const Mode mode(bar.fem);
  const double w = mode.frequency;
  for (const StepRule& rule : {StepRule{true, 0.2 / w, 0.4 * w, 0}, StepRule{true, 0.2 / w, 0, 0.3 / w},
                               StepRule{true, 0.02 / w, 0.1 * w, 0.2 / w}}) {
    const auto [frequency, damping] = fitMode(bar.fem, mode, rule);
    EXPECT_NEAR(frequency, w, 1e-3 * w);
    EXPECT_NEAR(damping, rule.damping_mass + rule.damping_stiffness * w * w, 1e-3 * w);
  }
}

TEST(FemBody, AdvanceShortensTheWholeMotionToTheLongestStep) {
  const BarModel bar = makeSmallBar();
  FemBody body(bar.fem, kGravity);
  VecX motion = makeRandomForce(bar.fem, 1e-4);
  EXPECT_EQ(body.advance(motion, 1), 1);
  body.reset();
  motion.segment<3>(30) = Vec3(0, 0.03, -0.04);
  EXPECT_NEAR(body.advance(motion, 0.01), 0.2, 1e-15);
  for (int i = 0; i < bar.fem.freeCount(); ++i) {
    const int node = bar.fem.freeNodes()[i];
    EXPECT_LT((body.positions()[node] - bar.fem.rest()[node] - 0.2 * motion.segment<3>(3 * i)).norm(), 1e-15);
  }
  for (int node = 0; node < bar.fem.nodeCount(); ++node) {
    if (bar.fem.freeIndex(node) >= 0) continue;
    EXPECT_EQ(body.positions()[node], bar.fem.rest()[node]);
  }
}

TEST(FemBody, AbandonedStepLeavesNoTrace) {
  const BarModel bar = makeSmallBar();
  const StepRule rule{true, 0.01, 2, 0.02};
  FemBody body(bar.fem, kGravity), undisturbed(bar.fem, kGravity);
  for (FemBody* each : {&body, &undisturbed}) {
    for (int k = 0; k < 3; ++k) takeStep(*each, rule);
  }
  body.beginStep();
  body.linearise(rule);
  body.advance(makeRandomForce(bar.fem, 1e-3), 1);
  body.abandonStep();
  EXPECT_EQ(body.positions(), undisturbed.positions());
  takeStep(body, rule);
  takeStep(undisturbed, rule);
  for (int node = 0; node < bar.fem.nodeCount(); ++node) {
    EXPECT_LT((body.positions()[node] - undisturbed.positions()[node]).norm(), 1e-12);
  }
}

TEST(FemBody, PlacedBodyIsAtRest) {
  const BarModel bar = makeSmallBar();
  const StepRule rule{true, 0.01, 2, 0.02};
  FemBody moving(bar.fem, kGravity), fresh(bar.fem, kGravity);
  for (int k = 0; k < 3; ++k) takeStep(moving, rule);
  moving.reset();
  EXPECT_EQ(moving.positions(), bar.fem.rest());
  takeStep(moving, rule);
  takeStep(fresh, rule);
  for (int node = 0; node < bar.fem.nodeCount(); ++node) {
    EXPECT_LT((moving.positions()[node] - fresh.positions()[node]).norm(), 1e-12);
  }
}

TEST(FemBody, StaticStepLeavesNoVelocity) {
  const BarModel bar = makeSmallBar();
  FemBody body(bar.fem, Vec3::Zero());
  const StepRule rule{true, 0.01, 0, 0};
  body.advance(makeRandomForce(bar.fem, 1e-4), 1);
  body.endStep(rule);
  body.beginStep();
  body.linearise(rule);
  EXPECT_GT((body.load() - body.imbalance()).norm(), 1e-3) << "momentum in N";
  body.endStep(StepRule());
  body.linearise(rule);
  EXPECT_LT((body.load() - body.imbalance()).norm(), 1e-12 * body.imbalance().norm());
}

}  // namespace
}  // namespace sinew
