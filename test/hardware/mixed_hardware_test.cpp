// One driver for servos, a CANopen drive, an ODrive and pressure boards on three buses at once.

#include <gtest/gtest.h>

#include <limits>

#include "hardware/virtual_hardware.h"
#include "sinew/common/config_error.h"
#include "sinew/hardware/hardware_driver.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.01;  // s

class MixedHardware : public testing::Test {
 protected:
  MixedHardware()
      : description(HardwareDescription::load(SINEW_SOURCE_DIR "/config/bench/hardware.yaml")),
        hardware(description),
        driver(description, makeBusGroup(description, hardware.opener())),
        reader(description.names(), description.quantities()) {}

  void cycle() {
    const Time begin = hardware.clock.now;
    driver.update(begin);
    hardware.clock.advanceTo(begin + duration(kPeriod));
    std::vector<double> tension(description.actuators.size(), 0);
    for (std::size_t i = 0; i < tension.size(); ++i)
      if (description.actuators[i].quantity == Quantity::kDisplacement)
        tension[i] = std::max(0., 1 + 200 * hardware.value(static_cast<int>(i)));
    hardware.step(seconds(hardware.clock.now - begin), tension);
  }

  bool start() {
    for (int n = 0; n < 50; ++n) cycle();
    driver.request(DriverRequest::kInit);
    for (int n = 0; n < 3000 && driver.report().state != DriverState::kReady; ++n) cycle();
    return driver.report().state == DriverState::kReady;
  }

  /// Everything towards `cable` [m] and `chamber` [Pa].
  void lead(double cable, double chamber, double time) {
    std::vector<std::uint8_t> modes;
    std::vector<double> goal;
    for (const ActuatorDescription& a : description.actuators) {
      modes.push_back(static_cast<std::uint8_t>(a.quantity));
      goal.push_back(a.quantity == Quantity::kDisplacement ? cable : chamber);
    }
    if (value.empty())
      for (const ActuatorReading& r : driver.report().actuators) value.push_back(r.measured);
    for (double t = 0; t < time; t += kPeriod) {
      for (std::size_t i = 0; i < value.size(); ++i) {
        const double step = 0.5 * description.actuators[i].rate_max * kPeriod;
        value[i] += std::max(-step, std::min(step, goal[i] - value[i]));
      }
      driver.offer(reader.read(7, ++sequence, 0, description.names(), modes, value, {}, hardware.clock.now));
      cycle();
    }
  }

  HardwareDescription description;
  VirtualHardware hardware;
  HardwareDriver driver;
  CommandReader reader;
  std::vector<double> value;
  std::uint32_t sequence = 0;
};

TEST_F(MixedHardware, StartsWithoutMovingAndFollowsOnEveryBus) {
  ASSERT_TRUE(start()) << driver.report().reason;
  std::vector<double> before;
  for (int i = 0; i < 7; ++i) before.push_back(hardware.value(i));
  lead(0.012, 30000, 3);
  ASSERT_EQ(driver.report().state, DriverState::kActive) << driver.report().reason;
  for (int i = 0; i < 7; ++i) {
    const bool pressure = description.actuators[static_cast<std::size_t>(i)].quantity == Quantity::kPressure;
    const double moved = hardware.value(i) - (pressure ? 0 : before[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(moved, pressure ? 30000 : 0.012, pressure ? 1500 : 3e-4) << i;
    EXPECT_TRUE(driver.report().actuators[static_cast<std::size_t>(i)].valid);
  }
}

TEST_F(MixedHardware, OneFaultStopsEverything) {
  ASSERT_TRUE(start()) << driver.report().reason;
  lead(0.012, 30000, 3);
  hardware.bus(1).setFrozen(0, true);
  for (int n = 0; n < 60 && driver.report().state == DriverState::kActive; ++n) lead(0.012, 30000, kPeriod);
  ASSERT_EQ(driver.report().state, DriverState::kFault);
  EXPECT_NE(driver.report().reason.find("cable_3 (id 3)"), std::string::npos) << driver.report().reason;
  for (int n = 0; n < 150; ++n) cycle();
  for (const int i : {0, 1, 3, 4, 5, 6}) EXPECT_FALSE(hardware.energised(i)) << i;
  for (const int i : {4, 5, 6}) EXPECT_LT(hardware.value(i), 3000) << "vented";
}

TEST_F(MixedHardware, ShutdownLetsGoOnEveryBus) {
  ASSERT_TRUE(start()) << driver.report().reason;
  lead(0.012, 30000, 2);
  driver.request(DriverRequest::kShutdown);
  for (int n = 0; n < 200; ++n) cycle();
  for (int i = 0; i < 7; ++i) EXPECT_FALSE(hardware.energised(i)) << i;
}

TEST(MixedHardwareDescription, IdentifiersThatMeanTwoThingsAreRefused) {
  HardwareDescription h = HardwareDescription::load(SINEW_SOURCE_DIR "/config/bench/hardware.yaml");
  h.actuators[3].id = 16;
  std::get<OdriveSettings>(h.actuators[3].settings).node = 16;  // its set points are 20C, the PDO of CANopen node 12
  h.actuators[2].id = 12;
  std::get<CanopenSettings>(h.actuators[2].settings).node = 12;
  VirtualHardware hardware(h);
  EXPECT_THROW(makeBusGroup(h, hardware.opener()), ConfigError);
}

}  // namespace
}  // namespace sinew
