// The finger against its post (thesis 4.5.3, Table 4.3): pulled forward until it has bent around it, and back by the
// inverse model.

#include <algorithm>

#include "inverse/contact_checks.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kPull = 0.018;  // m, of both cables

class FingerObstacle : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot = makeRobot(readShippedRobot("finger"));
  ForwardSimulator forward{robot};
  Actuation pull = forward.makeActuation();

  void bendAroundPost() {
    for (int k = 1; k <= 40; ++k) {
      pull.value = VecX::Constant(2, kPull * std::min(1.0, k / 30.0));
      ASSERT_EQ(forward.step(pull, 0.01), ForwardStatus::kSolved);
    }
    ASSERT_EQ(forward.settle(pull, 1e-9, 500), ForwardStatus::kSolved);
  }
};

TEST_F(FingerObstacle, GivesItsCablesBack) {
  bendAroundPost();
  EXPECT_GT(forward.contactForce().maxCoeff(), 0.1) << "N: it leans on the post";
  InverseController inverse(robot);
  CycleInput input = inverse.makeInput();
  CycleOutput output = inverse.makeOutput();
  input.targeted[0] = true;
  input.targets = forward.effectors();
  ContactWatch watch(inverse);
  for (int k = 0; k < 600; ++k) {
    inverse.step(input, output);
    watch.add(input, output);
  }
  const double worst = 100 * (output.displacement / kPull - VecX::Ones(2)).cwiseAbs().maxCoeff();
  checkFigure("finger_obstacle.displacement", worst, "<=", 0.3, "%");
  checkFigure("finger_obstacle.tip", 1e3 * output.effector_error, "<=", 0.01, "mm");
  watch.check("finger_obstacle", 0.0002);
}

// Room for one contact where there are several: that is said.
TEST_F(FingerObstacle, SaysThatContactsFindNoRoom) {
  bendAroundPost();
  RobotDescription description = readShippedRobot("finger");
  description.contacts.max_contacts = 1;
  InverseController inverse(makeRobot(description));
  CycleInput input = inverse.makeInput();
  CycleOutput output = inverse.makeOutput();
  input.targeted[0] = true;
  input.targets = forward.effectors();
  int crowded = 0;
  for (int k = 0; k < 300; ++k) {
    const CycleStatus status = inverse.step(input, output);
    EXPECT_TRUE(!output.contacts.crowded || status == CycleStatus::kDegraded);
    crowded += output.contacts.crowded;
  }
  EXPECT_GT(crowded, 100);
}

// Without the post the same pull leads elsewhere: the test above means something.
TEST_F(FingerObstacle, ThePostIsInItsWay) {
  bendAroundPost();
  RobotDescription description = readShippedRobot("finger");
  description.obstacles.clear();
  ForwardSimulator free(makeRobot(description));
  ASSERT_EQ(free.settle(pull, 1e-9, 500), ForwardStatus::kSolved);
  EXPECT_GT((free.effectors() - forward.effectors()).norm(), 0.005);
}

}  // namespace
}  // namespace sinew
