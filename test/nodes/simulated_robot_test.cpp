// Master of the simulated robot's bus: what the servos are told through the pseudo-terminal, the body does.

#include <geometry_msgs/PoseStamped.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/EffectorTargets.h>
#include <sinew/InjectFault.h>

#include <functional>
#include <string>

#include "ros_conversions.h"
#include "sinew/hardware/cable_transmission.h"
#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/serial_port.h"
#include "sinew/inverse/forward_simulator.h"

namespace sinew {
namespace {

constexpr double kPatience = 30;  // s, for a machine that is busy with other things

std::string parameter(const std::string& name) {
  return ros::NodeHandle("~").param<std::string>(name, "");
}

bool waitUntil(const std::function<bool()>& done) {
  const ros::SteadyTime start = ros::SteadyTime::now();
  while ((ros::SteadyTime::now() - start).toSec() < kPatience) {
    ros::spinOnce();
    if (done()) return true;
    ros::WallDuration(0.02).sleep();
  }
  return false;
}

std::uint8_t idOf(const ActuatorDescription& actuator) {
  return static_cast<std::uint8_t>(actuator.id);
}

class SimulatedRobotTest : public testing::Test {
 protected:
  SimulatedRobotTest()
      : hardware_(HardwareDescription::load(parameter("hardware"))), bus_(hardware_.buses[0].baud, duration(0.1)) {
    effectors_subscriber_ = node_.subscribe("plant/effectors", 10, &SimulatedRobotTest::onEffectors, this);
    tracker_subscriber_ = node_.subscribe("tracker/tip", 10, &SimulatedRobotTest::onTracker, this);
  }

  void SetUp() override {
    ASSERT_TRUE(connect());
    inject("drop", 0);
    inject("corrupt", 0);
  }

  bool connect() {
    bus_.attach(&port_);
    DynamixelBus::Identity identity;
    return waitUntil([&] {
      return (port_.isOpen() || port_.open(parameter("port"), hardware_.buses[0].baud)) &&
             bus_.ping(idOf(hardware_.actuators.front()), identity) == BusStatus::kOk;
    });
  }

  void onEffectors(const EffectorTargets& message) { effectors_ = message; }
  void onTracker(const geometry_msgs::PoseStamped& message) { tracked_ = toVec3(message.pose.position); }

  CableTransmission makeTransmission(const ActuatorDescription& actuator) const {
    return CableTransmission(actuator.cable.spool_radius, actuator.cable.sign, actuator.cable.torque_constant);
  }

  void reelIn(size_t i, double displacement) {
    const ActuatorDescription& actuator = hardware_.actuators[i];
    constexpr auto kMode = static_cast<std::int32_t>(OperatingMode::kExtendedPosition);
    ASSERT_EQ(BusStatus::kOk, bus_.write(idOf(actuator), servo_register::kTorqueEnable, 0));
    ASSERT_EQ(BusStatus::kOk, bus_.write(idOf(actuator), servo_register::kOperatingMode, kMode));
    ASSERT_EQ(BusStatus::kOk, bus_.write(idOf(actuator), servo_register::kTorqueEnable, 1));
    ASSERT_EQ(BusStatus::kOk, bus_.write(idOf(actuator), servo_register::kGoalPosition,
                                         makeTransmission(actuator).counts(displacement)));
  }

  /// By the servos' own account [m].
  VecX readReeledIn() {
    VecX reeled_in(static_cast<Eigen::Index>(hardware_.actuators.size()));
    for (size_t i = 0; i < hardware_.actuators.size(); ++i) {
      const ActuatorDescription& actuator = hardware_.actuators[i];
      std::int32_t counts = 0;
      EXPECT_EQ(BusStatus::kOk, bus_.read(idOf(actuator), servo_register::kPresentPosition, counts));
      reeled_in[static_cast<Eigen::Index>(i)] = makeTransmission(actuator).displacement(counts);
    }
    return reeled_in;
  }

  InjectFault::Response inject(const std::string& fault, double value) {
    InjectFault call;
    call.request.fault = fault;
    call.request.value = value;
    EXPECT_TRUE(ros::service::waitForService("simulated_robot/inject", ros::Duration(kPatience)));
    EXPECT_TRUE(ros::service::call("simulated_robot/inject", call));
    return call.response;
  }

  int countAnswers(int pings) {
    int answers = 0;
    DynamixelBus::Identity identity;
    for (int i = 0; i < pings; ++i) {
      answers += bus_.ping(idOf(hardware_.actuators.front()), identity) == BusStatus::kOk ? 1 : 0;
    }
    return answers;
  }

  ros::NodeHandle node_;
  HardwareDescription hardware_;
  SerialPort port_;
  DynamixelBus bus_;
  EffectorTargets effectors_;
  Vec3 tracked_ = Vec3::Constant(1e3);
  ros::Subscriber effectors_subscriber_, tracker_subscriber_;
};

TEST_F(SimulatedRobotTest, TheTipGoesWhereTheForwardProblemSettles) {
  // Every servo holds: a limp one would go on paying out.
  for (size_t i = 0; i < hardware_.actuators.size(); ++i) reelIn(i, i == 0 ? 0.012 : i == 5 ? 0.004 : 0);
  ASSERT_TRUE(waitUntil([this] {
    const VecX reeled_in = readReeledIn();
    return std::abs(reeled_in[0] - 0.012) < 1e-4 && std::abs(reeled_in[5] - 0.004) < 1e-4;
  }));

  ForwardSimulator reference(std::make_shared<RobotModel>(readRobotDescription(parameter("robot"))));
  Actuation actuation = reference.makeActuation();
  actuation.mode.assign(actuation.mode.size(), Actuation::Mode::kDisplacement);
  actuation.value = readReeledIn();
  reference.settle(actuation, 1e-9, 60);
  ASSERT_LT(reference.residualRelative(), 1e-9);
  const Vec3 tip = reference.effectors().head<3>();
  ASSERT_GT(tip.head<2>().norm(), 0.01) << "the pull has to show";
  EXPECT_TRUE(waitUntil([&] {
    return !effectors_.pose.empty() && (toVec3(effectors_.pose[0].position) - tip).norm() < 2e-4;
  })) << "tip expected at "
      << tip.transpose();
  EXPECT_TRUE(waitUntil([&] { return (tracked_ - tip).norm() < 3e-3; })) << "the tracker sees it, with its noise";
}

TEST_F(SimulatedRobotTest, ABadLineIsBadAndGoodAgain) {
  EXPECT_EQ(50, countAnswers(50));
  ASSERT_TRUE(inject("drop", 0.3).success);
  ASSERT_TRUE(inject("corrupt", 0.2).success);
  const int answers = countAnswers(200);
  EXPECT_NEAR(100, answers, 40);
  EXPECT_GT(bus_.counters().corrupted, 10u);
  EXPECT_GT(bus_.counters().missing, 20u);
  ASSERT_TRUE(inject("drop", 0).success);
  ASSERT_TRUE(inject("corrupt", 0).success);
  EXPECT_EQ(50, countAnswers(50));
}

TEST_F(SimulatedRobotTest, ALostLineComesBack) {
  ASSERT_TRUE(inject("disconnect", 0.5).success);
  EXPECT_EQ(0, countAnswers(1));
  port_.close();
  EXPECT_TRUE(connect());
}

TEST_F(SimulatedRobotTest, RefusesUnknownFaults) {
  EXPECT_FALSE(inject("explode", 1).success);
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "simulated_robot_test");
  const ros::NodeHandle node;
  return RUN_ALL_TESTS();
}
