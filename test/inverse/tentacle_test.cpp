// The tentacle curls until its ribs touch each other (thesis Fig. 4.15).

#include <algorithm>

#include "inverse/contact_checks.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

class Tentacle : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot = makeRobot(readShippedRobot("tentacle"));
};

TEST_F(Tentacle, CurlsUntilItTouchesItself) {
  InverseController controller(robot);
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  ContactWatch watch(controller);
  const SampledSignal targets = readShippedTargets(*robot, "tentacle/curl.csv");
  controller.resynchronise(VecX::Zero(robot->actuatorCount()));
  const double error = follow(controller, watch, targets, 0, 12, input, output);
  EXPECT_GT(watch.selfForce(), 0.1) << "N: ribs press against each other";
  checkFigure("tentacle.tip", 1e3 * error, "<=", 0.3, "mm");
  watch.check("tentacle", 0.0002);
}

TEST_F(Tentacle, GivesItsCableBack) {
  const RoundTrip trip = solveRoundTrip(robot, VecX::Constant(1, 0.028), 60, 600);
  EXPECT_GT(trip.contact_force, 0.05) << "N";
  checkFigure("tentacle.displacement", 100 * trip.difference / 0.028, "<=", 0.3, "%");
}

TEST_F(Tentacle, WithoutContactsItsRibsPass) {
  RobotDescription description = readShippedRobot("tentacle");
  description.contacts.self = false;
  ForwardSimulator passing(makeRobot(description));
  Actuation actuation = passing.makeActuation();
  for (int k = 1; k <= 100; ++k) {
    actuation.value = VecX::Constant(1, 0.0004 * k);
    ASSERT_EQ(passing.step(actuation, 0.01), ForwardStatus::kSolved);
  }
  EXPECT_GT(SelfDepth(*robot).calc(passing.nodes()), 0.001) << "m";
}

}  // namespace
}  // namespace sinew
