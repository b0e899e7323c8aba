// The beam between two obstacles (thesis Fig. 4.7): its tip goes up with the help of the one above and rests on the one
// below.

#include <algorithm>

#include "inverse/contact_checks.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

class Beam : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot = makeRobot(readShippedRobot("beam"));
};

TEST_F(Beam, SwaysBetweenItsObstacles) {
  InverseController controller(robot);
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  ContactWatch watch(controller);
  const SampledSignal targets = readShippedTargets(*robot, "beam/sway.csv");
  controller.resynchronise(VecX::Zero(robot->actuatorCount()));
  const double error = follow(controller, watch, targets, 0, 20, input, output);
  EXPECT_GT(watch.obstacleForce(), 0.5) << "N: it leans on them";
  EXPECT_GE(watch.mostContacts(), 15);
  checkFigure("beam.tip", 1e3 * error, "<=", 0.5, "mm");
  watch.check("beam", 0.0002);
}

// Both cables taut: a slack one may have any length.
TEST_F(Beam, GivesItsCablesBack) {
  for (const Eigen::Vector2d& pulled : {Eigen::Vector2d(0.018, 0.0112), Eigen::Vector2d(0.009, 0.012)}) {
    const RoundTrip trip = solveRoundTrip(robot, pulled, 40, 600);
    EXPECT_GT(trip.contact_force, 0.1) << "N";
    checkFigure(pulled[0] > pulled[1] ? "beam.displacement_up" : "beam.displacement_down",
                100 * trip.difference / pulled.maxCoeff(), "<=", 0.3, "%");
  }
}

}  // namespace
}  // namespace sinew
