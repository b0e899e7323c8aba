#include "sinew/inverse/contact_piece.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "inverse/contact_robot.h"

namespace sinew {
namespace {

/// The bar above a floor and under a cylinder, condensed with the contacts that are there.
class ContactPieceTest : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot =
      makeBarRobot(makeContactDescription({makeFloor(-0.003), makeCylinder(0.01, Vec3(0.06, 0.01, 0.033))}));
  CondensedRobot condensed{robot};
  ContactFinder finder{*robot};
  ContactPiece piece{4, 3, robot->maxContacts()};
  StageTimes times;
  std::mt19937 random{1};

  ContactPieceTest() {
    condensed.linearise(VecX::Constant(4, 0.3), StepRule(), times);
    EXPECT_TRUE(condensed.factorise(times));
    finder.find(condensed.body().positions(), times);
    condensed.addContacts(finder);
    condensed.condense(times);
    EXPECT_GT(condensed.contacts(), 10);
  }

  std::vector<char> draw(int most) {
    std::vector<char> pressing(static_cast<std::size_t>(condensed.contacts()), 0);
    for (int k = 0; k < most; ++k) pressing[random() % pressing.size()] = 1;
    return pressing;
  }

  VecX makeChange() {
    VecX change(4);
    for (int i = 0; i < 4; ++i) change[i] = std::uniform_real_distribution<double>(-1, 1)(random);
    return change;
  }

  /// Contact forces that keep the pressing contacts' gaps at zero.
  VecX calcForces(const std::vector<char>& pressing, const VecX& change) const {
    const int c = condensed.contacts(), first = condensed.firstContact();
    const MatX W = condensed.compliance();
    MatX system = MatX::Identity(c, c);
    VecX right = VecX::Zero(c);
    for (int i = 0; i < c; ++i) {
      if (!pressing[i]) continue;
      system.row(i) = W.row(first + i).segment(first, c);
      right[i] = -(condensed.gap()[i] + condensed.freeMotion()[first + i] + W.row(first + i).head(4).dot(change));
    }
    return system.fullPivLu().solve(right);
  }
};

TEST_F(ContactPieceTest, RowsMoveAsIfTheContactForcesWereSolvedFor) {
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<char> pressing = draw(3);
    ASSERT_TRUE(piece.reduce(condensed, pressing));
    const VecX change = makeChange(), force = calcForces(pressing, change);
    VecX rows = condensed.freeMotion() + condensed.compliance().leftCols(4) * change +
                condensed.compliance().rightCols(condensed.contacts()) * force;
    rows.head(4) += condensed.displacement();
    rows.tail(condensed.contacts()) += condensed.gap();
    const VecX reduced = piece.W() * change + piece.value();
    EXPECT_LT((reduced.head(7) - rows.head(7)).norm(), 1e-7 * rows.head(7).norm());
    VecX found_force(condensed.contacts()), found_gap(condensed.contacts());
    piece.calcContacts(change, found_force, found_gap);
    EXPECT_LT((found_force - force).norm(), 1e-6 * (1 + force.norm()));
    for (int i = 0; i < condensed.contacts(); ++i) {
      EXPECT_EQ(found_force[i] * found_gap[i], 0);
      EXPECT_NEAR(found_gap[i], pressing[i] ? 0 : rows[condensed.firstContact() + i], 1e-7 * rows.norm());
    }
  }
}

// Twice the same contact leaves the forces undetermined, not the motion.
TEST_F(ContactPieceTest, TakesContactsThatDependOnEachOther) {
  const std::vector<char> all(static_cast<std::size_t>(condensed.contacts()), 1);
  ASSERT_TRUE(piece.reduce(condensed, all));
  const VecX change = makeChange();
  VecX force(condensed.contacts()), gap(condensed.contacts());
  piece.calcContacts(change, force, gap);
  const VecX gaps = condensed.gap() + condensed.freeMotion().tail(condensed.contacts()) +
                    condensed.compliance().bottomLeftCorner(condensed.contacts(), 4) * change +
                    condensed.compliance().bottomRightCorner(condensed.contacts(), condensed.contacts()) * force;
  EXPECT_LT(gaps.cwiseAbs().maxCoeff(), 1e-7) << "m";
}

TEST_F(ContactPieceTest, WithoutContactsItIsTheRobotItself) {
  ASSERT_TRUE(piece.reduce(condensed, std::vector<char>(static_cast<std::size_t>(condensed.contacts()), 0)));
  EXPECT_EQ(MatX(piece.W()), MatX(condensed.compliance().leftCols(4)));
  EXPECT_EQ(VecX(piece.value().segment(4, 3)), VecX(condensed.freeMotion().segment(4, 3)));
}

}  // namespace
}  // namespace sinew
