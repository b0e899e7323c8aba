// The finger bent so far that its ribs press against each other.

#include <algorithm>

#include "check_line.h"
#include "inverse/robots.h"
#include "sinew/fem/fem_model.h"

namespace sinew {
namespace {

class SelfContact : public testing::Test {
 protected:
  static RobotDescription makeDescription(bool self) {
    RobotDescription description = readShippedRobot("finger");
    description.obstacles.clear();
    description.contacts.self = self;
    description.contacts.alarm_distance = 0.003;
    description.contacts.contact_distance = 0.0005;
    return description;
  }

  static void bend(ForwardSimulator& forward) {
    Actuation pull = forward.makeActuation();
    for (int k = 1; k <= 40; ++k) {
      pull.value = VecX::Constant(2, 0.022 * std::min(1.0, k / 30.0));
      ASSERT_EQ(forward.step(pull, 0.01), ForwardStatus::kSolved);
    }
    ASSERT_EQ(forward.settle(pull, 1e-8, 500), ForwardStatus::kSolved);
  }
};

TEST_F(SelfContact, TheRibsPressAndDoNotPass) {
  ForwardSimulator forward(makeRobot(makeDescription(true)));
  bend(forward);
  double depth = 0;
  for (int i = 0; i < forward.contacts().size(); ++i) depth = std::max(depth, -forward.contacts().row(i).gap);
  EXPECT_GT(forward.contactForce().maxCoeff(), 0.1) << "N";
  checkFigure("self_contact.depth", 1e3 * depth, "<=", 0.01, "mm");
}

// Forces within the body leave its weight to the base: the contacts' resultant on it is nothing.
TEST_F(SelfContact, ItsForcesBalanceEachOther) {
  ForwardSimulator forward(makeRobot(makeDescription(true)));
  bend(forward);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (int i = 0; i < forward.contacts().size(); ++i) {
    const ContactRow& row = forward.contacts().row(i);
    for (int k = 0; k < row.entries; ++k) {
      const ContactEntry& entry = forward.contacts().entries(i)[k];
      const Vec3 force = forward.contactForce()[i] * entry.gradient;
      sum += force;
      moment += forward.nodes()[static_cast<std::size_t>(entry.node)].cross(force);
    }
  }
  EXPECT_LT(sum.norm(), 1e-9 * forward.contactForce().sum()) << "N";
  EXPECT_LT(moment.norm(), 1e-6 * forward.contactForce().sum()) << "N m";
}

TEST_F(SelfContact, WithoutItTheRibsWouldPass) {
  ForwardSimulator passing(makeRobot(makeDescription(false))), touching(makeRobot(makeDescription(true)));
  bend(passing);
  bend(touching);
  EXPECT_GT((passing.effectors() - touching.effectors()).norm(), 0.002) << "m";
}

TEST_F(SelfContact, TheInverseReachesWhatTheForwardReached) {
  const auto robot = makeRobot(makeDescription(true));
  ForwardSimulator forward(robot);
  bend(forward);
  InverseController inverse(robot);
  CycleInput input = inverse.makeInput();
  CycleOutput output = inverse.makeOutput();
  input.targeted[0] = true;
  input.targets = forward.effectors();
  int held = 0;
  for (int k = 0; k < 600; ++k) held += inverse.step(input, output) == CycleStatus::kHeld;
  checkFigure("self_contact.tip", 1e3 * output.effector_error, "<=", 0.1, "mm");
  checkFigure("self_contact.held_cycles", held, "<=", 0, "1");
}

}  // namespace
}  // namespace sinew
