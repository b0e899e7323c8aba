// Three fingers of one robot close on a ball, follow it, and without it on each other.

#include <algorithm>

#include "common/complaint.h"
#include "inverse/contact_checks.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kGrip = 6;  // s into the shipped targets: the fingers have closed

class Gripper : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot = makeRobot(readShippedRobot("gripper"));
  InverseController controller{robot};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  ContactWatch watch{controller};
  SampledSignal targets = readShippedTargets(*robot, "gripper/close.csv");

  Gripper() { controller.resynchronise(VecX::Zero(robot->actuatorCount())); }

  /// Force of each finger on the ball [N], robot frame.
  std::array<Vec3, 3> calcGrip() const {
    std::array<Vec3, 3> force{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    for (int i = 0; i < output.contacts.count; ++i) {
      const ContactRow& row = controller.contacts().row(i);
      const std::size_t finger = row.point.y() < 0 ? 0 : row.point.x() > 0 ? 1 : 2;
      if (row.obstacle >= 0) force[finger] -= output.contacts.force[i] * row.normal;
    }
    return force;
  }
};

TEST_F(Gripper, ClosesOnTheBallAndLetsGo) {
  const double error = follow(controller, watch, targets, 0, kGrip, input, output);
  const std::array<Vec3, 3> grip = calcGrip();
  for (const Vec3& force : grip) EXPECT_GT(force.norm(), 0.1) << "N: every finger presses";
  const Vec3 sum = grip[0] + grip[1] + grip[2];
  EXPECT_LT(sum.head<2>().norm(), 0.1 * grip[0].norm()) << "three alike around the ball push it nowhere";
  const double error_opening = follow(controller, watch, targets, kGrip, 10, input, output);
  EXPECT_EQ(output.contacts.force.head(output.contacts.count).sum(), 0) << "N, open again";
  checkFigure("gripper.tips", 1e3 * std::max(error, error_opening), "<=", 0.5, "mm");
  watch.check("gripper", 0.0002);
}

TEST_F(Gripper, TheBallMayMove) {
  follow(controller, watch, targets, 0, kGrip, input, output);
  constexpr double kSpeed = 0.05;  // m/s
  const Pose waiting = robot->obstacles()[0].pose;
  for (int k = 0; k < 200; ++k) {
    const double way = 0.005 * std::sin(kSpeed / 0.005 * k * 0.01);
    input.obstacles = {{Pose(Eigen::Translation3d(way, 0.5 * way, 0)) * waiting, true}};
    controller.step(input, output);
    watch.add(input, output);
  }
  EXPECT_GT(watch.obstacleForce(), 0.1) << "N";
  watch.check("gripper_moving_ball", 0.0002);
}

TEST_F(Gripper, GivesItsCablesBack) {
  VecX pulled(6);
  pulled << 0.013, 0.012, 0.011, 0.012, 0.010, 0.010;
  const RoundTrip trip = solveRoundTrip(robot, pulled, 40, 400);
  EXPECT_GT(trip.contact_force, 0.1) << "N: it leans on the ball";
  checkFigure("gripper.displacement", 100 * trip.difference / pulled.maxCoeff(), "<=", 0.3, "%");
}

TEST_F(Gripper, WithoutTheBallItsFingersMeet) {
  const auto pull = [](const RobotDescription& description) {
    const auto model = makeRobot(description);
    ForwardSimulator forward(model);
    Actuation actuation = forward.makeActuation();
    for (int k = 1; k <= 100; ++k) {
      actuation.value = VecX::Constant(6, 0.014 * std::min(1.0, k / 80.0));
      EXPECT_EQ(forward.step(actuation, 0.01), ForwardStatus::kSolved);
    }
    return SelfDepth(*model).calc(forward.nodes());
  };
  RobotDescription description = readShippedRobot("gripper");
  description.obstacles.clear();
  checkFigure("gripper.fingers_depth", 1e3 * pull(description), "<=", 0.2, "mm");
  description.contacts.self_pairs = {{0, 0}};  // no finger with another
  EXPECT_GT(pull(description), 0.001) << "m: else they pass through each other";
}

TEST(GripperPieces, EveryOneIsToBeHeld) {
  RobotDescription description = readShippedRobot("gripper");
  description.fixed.boxes = {{Vec3(-1, -1, -1), Vec3(1, 0, 0.0001)}};  // of the first finger only
  const std::string words = complaintOf([&] { makeRobot(description); });
  EXPECT_NE(words.find("gripper.yaml: fixed: found 0 fixed nodes in the piece of node "), std::string::npos) << words;
}

TEST(GripperPieces, AreExpected) {
  RobotDescription description = readShippedRobot("gripper");
  EXPECT_TRUE(makeRobot(description)->warnings().empty());
  description.mesh_pieces = 1;
  const auto warnings = makeRobot(description)->warnings();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("in 3 pieces without common nodes, expected 1"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace sinew
