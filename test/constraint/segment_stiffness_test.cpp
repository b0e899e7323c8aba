#include "sinew/constraint/segment_stiffness.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "constraint/cable_bar.h"

namespace sinew {
namespace {

/// G^T B G with G = d(span) / d(free nodes), one 3x3 block w I per node.
MatX makeExpected(const FemModel& model, const EmbeddedPoint* first, const EmbeddedPoint& second, const Mat3& B) {
  MatX G = MatX::Zero(3, model.size());
  const auto add = [&](const EmbeddedPoint& point, double sign) {
    for (int i = 0; i < 4; ++i) {
      const int node = model.freeIndex(point.nodes[i]);
      if (node >= 0) G.middleCols<3>(3 * node) += sign * point.weights[i] * Mat3::Identity();
    }
  };
  if (first != nullptr) add(*first, -1);
  add(second, 1);
  return G.transpose() * B * G;
}

void expectStiffness(const CableBar& bar, const EmbeddedPoint* first, const EmbeddedPoint& second) {
  Mat3 B;
  B << 5, 1, -2, 1, 4, 0.5, -2, 0.5, 3;
  BlockMatrix matrix(bar.fem.pattern());
  SegmentStiffness(bar.fem, first, second).addTo(matrix, B);
  const MatX expected = makeExpected(bar.fem, first, second, B);
  EXPECT_GT(expected.norm(), 0);
  EXPECT_LT((matrix.makeDense() - expected).norm(), 1e-14 * expected.norm());
}

TEST(SegmentStiffness, CouplesTwoPointsOfTheBody) {
  const CableBar bar;
  expectStiffness(bar, &bar.points[1], bar.points[2]);
}

TEST(SegmentStiffness, LeavesFixedNodesOut) {
  const CableBar bar;
  const auto isFixed = [&](int node) { return bar.fem.freeIndex(node) < 0; };
  ASSERT_TRUE(std::any_of(bar.points[0].nodes.begin(), bar.points[0].nodes.end(), isFixed));
  expectStiffness(bar, &bar.points[0], bar.points[1]);
}

TEST(SegmentStiffness, HoldsAPointToTheWorld) {
  const CableBar bar;
  expectStiffness(bar, nullptr, bar.points[2]);
}

TEST(SegmentStiffness, AddsUpWhereBothEndsShareNodes) {
  const CableBar bar;
  EmbeddedPoint near = bar.points[2];
  near.weights = Vec4(0.1, 0.2, 0.3, 0.4);
  expectStiffness(bar, &near, bar.points[2]);
}

TEST(SegmentStiffness, NamesTheNodesThatItCouples) {
  const CableBar bar;
  std::vector<int> nodes = SegmentStiffness::coupledNodes(&bar.points[1], bar.points[2]);
  for (int i = 0; i < 4; ++i) {
    for (std::size_t end : {1U, 2U}) {
      EXPECT_NE(std::find(nodes.begin(), nodes.end(), bar.points[end].nodes[static_cast<std::size_t>(i)]), nodes.end());
    }
  }
  nodes = SegmentStiffness::coupledNodes(nullptr, bar.points[2]);
  EXPECT_EQ(nodes, std::vector<int>(bar.points[2].nodes.begin(), bar.points[2].nodes.end()));
}

}  // namespace
}  // namespace sinew
