#include "sinew/constraint/cable.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "constraint/cable_bar.h"

namespace sinew {
namespace {

class CableTest : public testing::Test {
 protected:
  CableBar bar;
  Cable cable{bar.description, bar.fem, bar.points};

  VecX calcForce(const std::vector<Vec3>& positions, double tension) const {
    ConstraintRows rows(bar.fem, 1, cable.maxEntries());
    cable.addRow(positions, rows);
    return tension * makeDenseRow(rows, 0, bar.fem.size());
  }

  std::vector<Vec3> calcPoints(const std::vector<Vec3>& positions) const {
    std::vector<Vec3> points;
    cable.calcPoints(positions, points);
    return points;
  }
};

TEST_F(CableTest, RunsFromItsPullPointThroughItsViaPoints) {
  const std::vector<Vec3> positions = bar.makeDeformed(1, 1.2);
  const std::vector<Vec3> points = calcPoints(positions);
  ASSERT_EQ(points.size(), 4U);
  EXPECT_EQ(cable.points(), 4);
  EXPECT_EQ(points[0], bar.description.pull_point);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LT((points[i + 1] - calcPosition(bar.points[i], positions)).norm(), 1e-15);
}

TEST_F(CableTest, DisplacementIsTheLengthPulledIn) {
  EXPECT_NEAR(cable.calcDisplacement(bar.fem.rest()), 0, 1e-15);
  for (double stretch : {0.7, 1.3}) {
    const std::vector<Vec3> rest = calcPoints(bar.fem.rest()), now = calcPoints(bar.makeDeformed(2, stretch));
    double shortened = 0;
    for (std::size_t i = 1; i < now.size(); ++i)
      shortened += (rest[i] - rest[i - 1]).norm() - (now[i] - now[i - 1]).norm();
    EXPECT_NEAR(cable.calcDisplacement(bar.makeDeformed(2, stretch)), shortened, 1e-15);
    EXPECT_EQ(shortened > 0, stretch < 1);
  }
}

TEST_F(CableTest, RowIsTheDerivativeOfTheDisplacement) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const std::vector<Vec3> positions = bar.makeDeformed(seed, 1.1);
    const MatX expected = bar.differentiate(
        [&](const std::vector<Vec3>& x) { return VecX::Constant(1, cable.calcDisplacement(x)); }, positions);
    EXPECT_LT((calcForce(positions, 1) - expected.transpose()).norm(), 1e-8 * expected.norm());
  }
}

// The whole cable pulls on the body with its tension along the first segment, towards the pull point.
TEST_F(CableTest, PullsOnTheBodyAsAWhole) {
  CableBar free;
  free.fem =
      FemModel(free.mesh, free.makeMaterials(), std::vector<bool>(free.mesh.nodes.size(), false), free.makeCouplings());
  const Cable whole(free.description, free.fem, free.points);
  const std::vector<Vec3> positions = free.makeDeformed(3, 1.1);
  ConstraintRows rows(free.fem, 1, whole.maxEntries());
  whole.addRow(positions, rows);
  const VecX row = makeDenseRow(rows, 0, free.fem.size());
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < free.fem.freeCount(); ++i) sum += row.segment<3>(3 * i);
  const Vec3 towards = (free.description.pull_point - calcPosition(free.points[0], positions)).normalized();
  EXPECT_LT((sum - towards).norm(), 1e-12);
}

TEST_F(CableTest, LoadStiffnessIsTheDerivativeOfItsForces) {
  constexpr double kTension = 3;  // N
  for (unsigned seed = 0; seed < 3; ++seed) {
    const std::vector<Vec3> positions = bar.makeDeformed(seed, 1.1);
    const MatX expected =
        -bar.differentiate([&](const std::vector<Vec3>& x) { return calcForce(x, kTension); }, positions);
    BlockMatrix stiffness(bar.fem.pattern());
    cable.addLoadStiffness(positions, kTension, stiffness);
    EXPECT_LT((stiffness.makeDense() - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST_F(CableTest, LoadStiffnessOfASlackOrPushingCableIsNone) {
  BlockMatrix stiffness(bar.fem.pattern());
  for (double tension : {0.0, -2.0, std::nan("")}) cable.addLoadStiffness(bar.makeDeformed(1, 1), tension, stiffness);
  EXPECT_EQ(stiffness.makeDense().norm(), 0);
}

TEST_F(CableTest, SegmentWithoutLengthIsPassedOver) {
  std::vector<EmbeddedPoint> points = bar.points;
  points.insert(points.begin() + 1, points[1]);
  const Cable doubled(bar.description, bar.fem, points);
  const std::vector<Vec3> positions = bar.makeDeformed(1, 1.1);
  ConstraintRows rows(bar.fem, 1, doubled.maxEntries());
  doubled.addRow(positions, rows);
  EXPECT_LT((makeDenseRow(rows, 0, bar.fem.size()) - calcForce(positions, 1)).norm(), 1e-14);
  BlockMatrix once(bar.fem.pattern()), twice(bar.fem.pattern());
  cable.addLoadStiffness(positions, 1, once);
  doubled.addLoadStiffness(positions, 1, twice);
  EXPECT_LT((once.makeDense() - twice.makeDense()).norm(), 1e-12 * once.makeDense().norm());
}

class TubeTest : public CableTest {
 protected:
  TubeTest() {
    bar.description.tube_stiffness = 20;
    cable = Cable(bar.description, bar.fem, bar.points);
  }

  double calcEnergy(const std::vector<Vec3>& positions) const {
    const std::vector<Vec3> rest = calcPoints(bar.fem.rest()), now = calcPoints(positions);
    double energy = 0;
    for (std::size_t i = 1; i + 1 < now.size(); ++i) {
      const double length = (rest[i + 1] - rest[i]).norm(), change = (now[i + 1] - now[i]).norm() - length;
      energy += 0.5 * bar.description.tube_stiffness / length * change * change;
    }
    return energy;
  }

  VecX calcTubeForce(const std::vector<Vec3>& positions) const {
    VecX force = VecX::Zero(bar.fem.size());
    cable.addTube(positions, &force, nullptr);
    return force;
  }

  MatX calcTubeTangent(const std::vector<Vec3>& positions) const {
    BlockMatrix tangent(bar.fem.pattern());
    cable.addTube(positions, nullptr, &tangent);
    return tangent.makeDense();
  }

  MatX differentiateForce(const std::vector<Vec3>& positions) const {
    return -bar.differentiate([&](const std::vector<Vec3>& x) { return calcTubeForce(x); }, positions);
  }
};

TEST_F(TubeTest, ForceIsTheGradientOfItsSprings) {
  for (double stretch : {0.8, 1.2}) {
    const std::vector<Vec3> positions = bar.makeDeformed(4, stretch);
    const MatX gradient =
        bar.differentiate([&](const std::vector<Vec3>& x) { return VecX::Constant(1, calcEnergy(x)); }, positions);
    EXPECT_LT((calcTubeForce(positions) + gradient.transpose()).norm(), 1e-7 * gradient.norm());
  }
  EXPECT_LT(calcTubeForce(bar.fem.rest()).norm(), 1e-12);
}

TEST_F(TubeTest, TangentOfAStretchedTubeIsExact) {
  const std::vector<Vec3> positions = bar.makeDeformed(5, 1.3);
  const MatX expected = differentiateForce(positions);
  EXPECT_LT((calcTubeTangent(positions) - expected).norm(), 1e-6 * expected.norm());
}

// A compressed tube buckles; its tangent is the semi-definite part, above the exact one.
TEST_F(TubeTest, TangentOfACompressedTubeStaysSemidefinite) {
  const std::vector<Vec3> positions = bar.makeDeformed(5, 0.7);
  const MatX tangent = calcTubeTangent(positions), exact = differentiateForce(positions);
  const auto smallest = [](const MatX& matrix) {
    return Eigen::SelfAdjointEigenSolver<MatX>((matrix + matrix.transpose()) / 2).eigenvalues().minCoeff();
  };
  EXPECT_LT(smallest(exact), -1);
  EXPECT_GT(smallest(tangent), -1e-9 * tangent.norm());
  EXPECT_GT(smallest(tangent - exact), -1e-6 * tangent.norm());
}

TEST_F(CableTest, HasNoTubeUnlessItIsTold) {
  VecX force = VecX::Zero(bar.fem.size());
  BlockMatrix tangent(bar.fem.pattern());
  cable.addTube(bar.makeDeformed(1, 1.2), &force, &tangent);
  EXPECT_EQ(force.norm(), 0);
  EXPECT_EQ(tangent.makeDense().norm(), 0);
}

}  // namespace
}  // namespace sinew
