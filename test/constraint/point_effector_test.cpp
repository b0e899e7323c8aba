#include "sinew/constraint/point_effector.h"

#include <gtest/gtest.h>

#include "constraint/cable_bar.h"

namespace sinew {
namespace {

const Vec3 kTarget(0.05, -0.01, 0.02);

PointEffector makeEffector(const CableBar& bar, const std::array<bool, 3>& axes, double weight) {
  EffectorDescription description;
  description.axes = axes;
  description.weight = weight;
  return PointEffector(description, bar.points[2]);
}

VecX calcError(const PointEffector& effector, const std::vector<Vec3>& positions) {
  VecX error = VecX::Constant(effector.rowCount() + 1, 7);
  effector.calcError(positions, kTarget, error.data());
  EXPECT_EQ(error[effector.rowCount()], 7);
  return error.head(effector.rowCount());
}

TEST(PointEffector, ErrorIsTheWeightedWayFromTheTargetAlongItsAxes) {
  const CableBar bar;
  const std::vector<Vec3> positions = bar.makeDeformed(1, 1.2);
  const Vec3 way = calcPosition(bar.points[2], positions) - kTarget;
  const PointEffector whole = makeEffector(bar, {{true, true, true}}, 2);
  EXPECT_EQ(whole.rowCount(), 3);
  EXPECT_LT((whole.calcPosition(positions) - kTarget - way).norm(), 1e-15);
  EXPECT_LT((calcError(whole, positions) - 2 * way).norm(), 1e-15);
  const PointEffector plane = makeEffector(bar, {{true, false, true}}, 0.5);
  EXPECT_EQ(plane.rowCount(), 2);
  EXPECT_LT((calcError(plane, positions) - 0.5 * Eigen::Vector2d(way.x(), way.z())).norm(), 1e-15);
}

TEST(PointEffector, RowsAreTheDerivativesOfTheError) {
  const CableBar bar;
  const std::vector<Vec3> positions = bar.makeDeformed(2, 1.1);
  for (unsigned choice = 1; choice < 8; ++choice) {
    const PointEffector effector =
        makeEffector(bar, {{(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0}}, 0.3 * choice);
    ConstraintRows rows(bar.fem, 3, 12);
    effector.addRows(rows);
    ASSERT_EQ(rows.rows(), effector.rowCount());
    const MatX expected =
        bar.differentiate([&](const std::vector<Vec3>& x) { return calcError(effector, x); }, positions);
    for (int row = 0; row < rows.rows(); ++row) {
      EXPECT_LT((makeDenseRow(rows, row, bar.fem.size()) - expected.row(row).transpose()).norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace sinew
