#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "simulated_robot_node_faults.h"
#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/simulated_line.h"

namespace sinew {
namespace {

class FaultDeskTest : public testing::Test {
 protected:
  FaultDeskTest()
      : bus_({1, 2}),
        desk_(bus_, {"left", "right"}, LineFaults(), [this](double duration) { away_.push_back(duration); }),
        line_(bus_),
        master_(1000000, duration(0.005)) {
    master_.attach(&line_);
  }

  BusStatus ping(std::uint8_t id) {
    DynamixelBus::Identity identity;
    return master_.ping(id, identity);
  }

  SimulatedServoBus bus_;
  std::vector<double> away_;
  FaultDesk desk_;
  SimulatedLine line_;
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
  bus_.step(0.01);
  master_.read(1, servo_register::kHardwareError, error);
  EXPECT_EQ(kOverheating, error & kOverheating);
  ASSERT_TRUE(desk_.inject("supply_dip", "", 8).success);
  bus_.step(0.01);
  master_.read(2, servo_register::kHardwareError, error);
  EXPECT_EQ(kVoltageError, error & kVoltageError);
}

TEST_F(FaultDeskTest, APowerCycleLosesTheTurns) {
  bus_.setShaftAngle(0, 9);
  ASSERT_TRUE(desk_.inject("power_cycle", "left", 0).success);
  bus_.step(0.01);
  std::int32_t position = 0;
  ASSERT_EQ(BusStatus::kOk, master_.read(1, servo_register::kPresentPosition, position));
  EXPECT_LT(position, kCountsPerTurn);
  EXPECT_EQ(9, bus_.shaftAngle(0));
}

TEST_F(FaultDeskTest, DisconnectsForTheGivenTime) {
  ASSERT_TRUE(desk_.inject("disconnect", "", 0.5).success);
  EXPECT_EQ(std::vector<double>{0.5}, away_);
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
