#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "simulated_robot_node_faults.h"
#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/serial_port.h"

namespace sinew {
namespace {

HardwareDescription describe() {
  HardwareDescription hardware = HardwareDescription::parse(
      "hardware:\n"
      "  bus: {protocol: dynamixel2, port: /dev/none, baud: 1000000, simulated: true, reply_timeout: 0.05,"
      " missing_limit: 10}\n"
      "  rate: 100\n  command_timeout: 0.1\n  hold_limit: 0.5\n  relax_time: 0.4\n  bus_watchdog: 0.1\n"
      "  servo: {spool_radius: 0.01, sign: 1, displacement_min: -0.03, displacement_max: 0.06, rate_max: 0.04,"
      " tension_max: 20, torque_constant: 1.78, on_timeout: relax, homing: {method: present}}\n"
      "  actuators: [{name: left, id: 1}, {name: right, id: 2}]\n",
      "test");
  hardware.movePorts("/tmp/sinew_faults_test_" + std::to_string(getpid()));
  return hardware;
}

class FaultDeskTest : public testing::Test {
 protected:
  FaultDeskTest()
      : hardware_(describe()),
        desk_(hardware_, LineFaults(), [this](int bus, double time) { away_.emplace_back(bus, time); }),
        master_(1000000, duration(0.05)) {
    hardware_.connect(0);
    EXPECT_TRUE(line_.open(hardware_.port(0), 1000000)) << line_.error();
    master_.attach(&line_);
  }

  BusStatus ping(std::uint8_t id) {
    DynamixelBus::Identity identity;
    return master_.ping(id, identity);
  }

  SimulatedHardware hardware_;
  std::vector<std::pair<int, double>> away_;
  FaultDesk desk_;
  SerialPort line_;
  DynamixelBus master_;
};

TEST_F(FaultDeskTest, DroppedPacketsNeverArrive) {
  ASSERT_EQ(BusStatus::kOk, ping(1));
  ASSERT_TRUE(desk_.inject("drop", "", 1).success);
  EXPECT_EQ(BusStatus::kMissing, ping(1));
  EXPECT_EQ(1u, desk_.lineCounts().dropped);
  ASSERT_TRUE(desk_.inject("drop", "", 0).success);
  EXPECT_EQ(BusStatus::kOk, ping(1));
  EXPECT_EQ(2u, desk_.counts().at("drop"));
}

TEST_F(FaultDeskTest, CorruptedPacketsAreRefused) {
  ASSERT_TRUE(desk_.inject("corrupt", "", 1).success);
  EXPECT_NE(BusStatus::kOk, ping(1));
  EXPECT_EQ(1u, desk_.lineCounts().corrupted);
}

TEST_F(FaultDeskTest, FreezesOnlyTheNamedActuator) {
  ASSERT_TRUE(desk_.inject("freeze", "right", 1).success);
  EXPECT_EQ(BusStatus::kOk, ping(1));
  EXPECT_EQ(BusStatus::kMissing, ping(2));
  ASSERT_TRUE(desk_.inject("freeze", "", 0).success);
  EXPECT_EQ(BusStatus::kOk, ping(2));
}

TEST_F(FaultDeskTest, HeatAndSupplyRaiseAlarms) {
  std::int32_t error = 0;
  ASSERT_TRUE(desk_.inject("overheat", "left", 95).success);
  hardware_.step(0.01);
  master_.read(1, servo_register::kHardwareError, error);
  EXPECT_EQ(kOverheating, error & kOverheating);
  ASSERT_TRUE(desk_.inject("supply_dip", "", 8).success);
  hardware_.step(0.01);
  master_.read(2, servo_register::kHardwareError, error);
  EXPECT_EQ(kVoltageError, error & kVoltageError);
}

TEST_F(FaultDeskTest, APowerCycleForgetsWhatWasWritten) {
  ASSERT_EQ(BusStatus::kOk, master_.write(1, servo_register::kTorqueEnable, 1));
  ASSERT_TRUE(desk_.inject("power_cycle", "left", 0).success);
  std::int32_t torque = 1;
  ASSERT_EQ(BusStatus::kOk, master_.read(1, servo_register::kTorqueEnable, torque));
  EXPECT_EQ(0, torque);
}

TEST_F(FaultDeskTest, NothingOfTheRobotsPullArrivesThroughASnappedCable) {
  const auto drag = [this] {
    const double from = hardware_.reeledIn(0);
    hardware_.setTension(0, 5);
    hardware_.step(0.05);
    return from - hardware_.reeledIn(0);
  };
  EXPECT_GT(drag(), 1e-4) << "a limp servo gives way";
  ASSERT_TRUE(desk_.inject("snap", "left", 1).success);
  EXPECT_EQ(drag(), 0);
  ASSERT_TRUE(desk_.inject("snap", "left", 0).success);
  EXPECT_GT(drag(), 1e-4);
}

TEST_F(FaultDeskTest, DisconnectsForTheGivenTime) {
  ASSERT_TRUE(desk_.inject("disconnect", "", 0.5).success);
  EXPECT_EQ((std::vector<std::pair<int, double>>{{0, 0.5}}), away_);
  ASSERT_TRUE(desk_.inject("disconnect", "right", 0.2).success) << "the bus of an actuator";
  EXPECT_EQ(2u, away_.size());
  EXPECT_FALSE(desk_.inject("disconnect", "nowhere", 0.2).success);
}

TEST_F(FaultDeskTest, RefusesWhatItCannotDo) {
  EXPECT_FALSE(desk_.inject("explode", "", 1).success);
  EXPECT_FALSE(desk_.inject("freeze", "middle", 1).success);
  EXPECT_FALSE(desk_.inject("drop", "", 1.1).success);
  EXPECT_FALSE(desk_.inject("drop", "", std::nan("")).success);
  EXPECT_FALSE(desk_.inject("supply_dip", "", -1).success);
  EXPECT_FALSE(desk_.inject("disconnect", "", 0).success);
  EXPECT_TRUE(desk_.counts().empty());
  ASSERT_TRUE(desk_.inject("drop", "", 0.7).success);
  EXPECT_FALSE(desk_.inject("corrupt", "", 0.4).success) << "together more than 1";
  EXPECT_EQ(BusStatus::kOk, (desk_.inject("drop", "", 0), ping(1)));
}

}  // namespace
}  // namespace sinew
