#include "sinew/inverse/contact_stiffness.h"

#include <gtest/gtest.h>

#include <set>

#include "inverse/contact_robot.h"
#include "sinew/contact/feature_pair.h"
#include "sinew/linalg/block_matrix.h"

namespace sinew {
namespace {

constexpr double kStep = 1e-6;  // m

/// Nodal forces of contacts that press with `force`, and which pairs of features they are.
struct Push {
  VecX force;
  std::vector<std::uint64_t> keys;
};

class ContactStiffnessTest : public testing::Test {
 protected:
  StageTimes times;

  static Push calcPush(const RobotModel& robot, const ContactList& list, const VecX& press) {
    Push push{VecX::Zero(robot.fem().size()), {}};
    for (int c = 0; c < list.size(); ++c) {
      push.keys.push_back(list.row(c).key);
      for (int k = 0; k < list.row(c).entries; ++k) {
        const ContactEntry& entry = list.entries(c)[k];
        const int free = robot.fem().freeIndex(entry.node);
        if (free >= 0) push.force.segment<3>(3 * free) += press[c] * entry.gradient;
      }
    }
    return push;
  }

  /// Worst entry of the stiffness against central differences of the contacts' forces, relative to its largest.
  void expectDerivative(const ObstacleDescription& obstacle, const std::set<PairKind>& kinds) {
    const auto robot = makeBarRobot(makeContactDescription({obstacle}));
    const FemModel& fem = robot->fem();
    ContactFinder finder(*robot);
    std::vector<Vec3> nodes = fem.rest();
    double phase = 0;
    for (Vec3& node : nodes) node += 2e-4 * Vec3(std::sin(phase), std::cos(2 * phase), 0), phase += 3;
    const ContactList& list = finder.find(nodes, times);
    VecX press = VecX::Zero(list.size());
    int count = 0;
    for (int c = 0; c < list.size(); ++c) {
      if (kinds.count(kindOf(list.row(c).key)) != 0) press[c] = 1 + 0.5 * count++;
    }
    ASSERT_GT(count, 0) << "no such contact";
    ContactStiffness stiffness(robot->maxContacts());
    stiffness.update(finder, press, nodes);
    BlockMatrix matrix(fem.pattern());
    stiffness.addTo(fem, matrix);
    const MatX K = matrix.makeDense();
    const std::vector<std::uint64_t> keys = calcPush(*robot, list, press).keys;
    int compared = 0;
    for (int column = 0; column < fem.size(); ++column) {
      if (K.col(column).isZero(0)) continue;
      Vec3& node = nodes[fem.freeNodes()[column / 3]];
      node[column % 3] += kStep;
      const Push after = calcPush(*robot, finder.find(nodes, times), press);
      node[column % 3] -= 2 * kStep;
      const Push before = calcPush(*robot, finder.find(nodes, times), press);
      node[column % 3] += kStep;
      if (after.keys != keys || before.keys != keys) continue;  // another pair of features took over
      const VecX expected = -(after.force - before.force) / (2 * kStep);
      EXPECT_LT((K.col(column) - expected).cwiseAbs().maxCoeff(), 1e-3 * K.cwiseAbs().maxCoeff()) << column;
      ++compared;
    }
    EXPECT_GT(compared, 2);
  }
};

TEST_F(ContactStiffnessTest, VertexOnABall) {
  expectDerivative(makeSphere(0.01, Vec3(0.1, 0.0, 0.032)), {PairKind::kVertexSmooth});
}

TEST_F(ContactStiffnessTest, EdgeOnABall) {
  expectDerivative(makeSphere(0.01, Vec3(0.0562, -0.002, 0.031)), {PairKind::kEdgeSmooth});
}

TEST_F(ContactStiffnessTest, FaceOnABall) {
  expectDerivative(makeSphere(0.01, Vec3(0.059, 0.0065, 0.0325)), {PairKind::kFaceSmooth});
}

TEST_F(ContactStiffnessTest, EdgeOnACylinder) {
  expectDerivative(makeCylinder(0.01, Vec3(0.0562, 0.01, 0.0325)), {PairKind::kEdgeSmooth});
}

TEST_F(ContactStiffnessTest, AFlatFloorTurnsNothing) {
  const auto robot = makeBarRobot(makeContactDescription({makeFloor(-0.003)}));
  ContactFinder finder(*robot);
  const ContactList& list = finder.find(robot->fem().rest(), times);
  ASSERT_GT(list.size(), 0);
  ContactStiffness stiffness(robot->maxContacts());
  stiffness.update(finder, VecX::Ones(list.size()), robot->fem().rest());
  BlockMatrix matrix(robot->fem().pattern());
  stiffness.addTo(robot->fem(), matrix);
  EXPECT_TRUE(matrix.makeDense().isZero(0));
}

}  // namespace
}  // namespace sinew
