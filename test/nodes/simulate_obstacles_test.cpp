#include "simulate_obstacles.h"

#include <gtest/gtest.h>

#include "common/complaint.h"
#include "inverse/contact_robot.h"

namespace sinew {
namespace {

class SimulateObstacles : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot =
      makeBarRobot(makeContactDescription({makeFloor(-0.01), makeSphere(0.01, Vec3(0.05, 0.01, 0.04))}));
  std::vector<ObstacleState> states;

  ObstacleSignal read(const std::string& text) const {
    return ObstacleSignal(CsvTable::fromText(text, "obstacles.csv"), *robot);
  }
};

TEST_F(SimulateObstacles, StayWhereTheDescriptionHasThem) {
  ObstacleSignal(*robot).calcStates(3, states);
  ASSERT_EQ(states.size(), 2U);
  EXPECT_TRUE(states[0].present);
  EXPECT_EQ(states[1].pose.translation(), Vec3(0.05, 0.01, 0.04));
}

TEST_F(SimulateObstacles, MoveTurnComeAndGo) {
  const ObstacleSignal signal = read(
      "t,obstacle_ball_x,obstacle_ball_y,obstacle_ball_z,obstacle_ball_qx,obstacle_ball_qy,obstacle_ball_qz,"
      "obstacle_ball_qw,obstacle_ball_present\n"
      "0,0,0,0,0,0,0,1,1\n"
      "2,0.1,0.2,-0.1,0,0,2,0,0\n");
  signal.calcStates(0.5, states);
  EXPECT_LT((states[1].pose.translation() - Vec3(0.025, 0.05, -0.025)).norm(), 1e-12);
  EXPECT_TRUE(states[1].present);
  EXPECT_LT((states[0].pose.translation() - Vec3(0, 0, -0.01)).norm(), 1e-12) << "the floor stays";
  signal.calcStates(5, states);
  EXPECT_FALSE(states[1].present);
  EXPECT_LT((states[1].pose.linear() * Vec3::UnitX() + Vec3::UnitX()).norm(), 1e-12);
}

TEST_F(SimulateObstacles, ComplainsByName) {
  EXPECT_NE(complaintOf([&] { read("t,obstacle_bal_x\n0,1\n"); }).find("obstacle_bal_x"), std::string::npos);
  EXPECT_NE(complaintOf([&] { read("t,obstacle_ball_x\n0,1\n"); }).find("obstacle_ball_y"), std::string::npos);
  const std::string zero = "t,obstacle_ball_qx,obstacle_ball_qy,obstacle_ball_qz,obstacle_ball_qw\n0,0,0,0,0\n";
  EXPECT_NE(complaintOf([&] { read(zero); }).find("a unit quaternion"), std::string::npos);
}

}  // namespace
}  // namespace sinew
