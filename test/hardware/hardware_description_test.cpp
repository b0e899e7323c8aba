#include "sinew/hardware/hardware_description.h"

#include <gtest/gtest.h>

#include "hardware/driver_bench.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

std::string complaint(const std::string& text) {
  try {
    HardwareDescription::parse(text, "robot.yaml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no complaint";
}

std::string replaced(const std::string& from, const std::string& to) {
  std::string text = makeHardwareYaml(2);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expectComplaint(const std::string& text, const std::vector<std::string>& words) {
  const std::string found = complaint(text);
  for (const std::string& w : words) EXPECT_NE(found.find(w), std::string::npos) << "'" << w << "' in: " << found;
}

TEST(HardwareDescription, ReadsTheTrunk) {
  const HardwareDescription h = HardwareDescription::load(SINEW_SOURCE_DIR "/config/trunk/hardware.yaml");
  ASSERT_EQ(h.actuators.size(), 8u);
  EXPECT_EQ(h.buses[0].baud, 1000000);
  EXPECT_EQ(h.rate, 100);
  EXPECT_EQ(h.command_timeout, 0.1);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(h.actuators[i].name, "cable_" + std::to_string(i + 1));
    EXPECT_EQ(h.actuators[i].id, i + 1);
    EXPECT_EQ(h.actuators[i].cable.spool_radius, 0.010);
    EXPECT_EQ(h.actuators[i].min, -0.03);
    EXPECT_EQ(h.actuators[i].max, 0.06);
    EXPECT_EQ(h.actuators[i].rate_max, 0.045);
    EXPECT_EQ(h.actuators[i].cable.tension_max, 20);
    EXPECT_EQ(h.actuators[i].on_timeout, OnTimeout::kRelax);
  }
}

TEST(HardwareDescription, ReadsAMixedBench) {
  const HardwareDescription h = HardwareDescription::load(SINEW_SOURCE_DIR "/config/bench/hardware.yaml");
  ASSERT_EQ(h.buses.size(), 3u);
  EXPECT_TRUE(h.buses[1].isCanInterface());
  EXPECT_EQ(h.buses[1].bitrate, 1000000);
  ASSERT_EQ(h.actuators.size(), 7u);
  EXPECT_EQ(h.actuatorsOn(1), std::vector<int>({2, 3, 4}));
  EXPECT_EQ(h.actuators[2].device, DeviceType::kCanopen);
  EXPECT_EQ(std::get<CanopenSettings>(h.actuators[2].settings).gear, 10);
  EXPECT_EQ(h.actuators[3].device, DeviceType::kOdrive);
  EXPECT_EQ(h.actuators[3].watch.current_max, 15);
  EXPECT_EQ(h.actuators[4].quantity, Quantity::kPressure);
  EXPECT_EQ(h.actuators[6].channel, 1);
  EXPECT_EQ(h.actuators[6].on_timeout, OnTimeout::kVent);
  EXPECT_EQ(h.actuators[0].watch.effort_missing, 10);
  HardwareDescription moved = h;
  moved.movePorts("/tmp/x");
  EXPECT_EQ(moved.buses[1].port, "/tmp/x_can");
  EXPECT_FALSE(moved.buses[1].isCanInterface());
}

TEST(HardwareDescription, AnActuatorOverridesWhatIsCommon) {
  const HardwareDescription h =
      HardwareDescription::parse(replaced("id: 2}", "id: 2, sign: -1, spool_radius: 0.02}"), "x");
  EXPECT_EQ(h.actuators[0].cable.sign, 1);
  EXPECT_EQ(h.actuators[1].cable.sign, -1);
  EXPECT_EQ(h.actuators[1].cable.spool_radius, 0.02);
}

TEST(HardwareDescription, AMissingKeyIsNamedInFull) {
  expectComplaint(replaced(" rate_max: 0.04,", ""),
                  {"robot.yaml: hardware.actuators[0].rate_max", "hardware.servo.rate_max", "nothing", "m/s"});
  expectComplaint(replaced("  rate: 100\n", ""), {"robot.yaml: hardware.rate", "nothing", "Hz"});
  expectComplaint(replaced(" port: /dev/none,", ""), {"hardware.bus.port", "nothing"});
  expectComplaint("{}", {"robot.yaml: hardware", "nothing"});
}

TEST(HardwareDescription, AWrongValueIsShown) {
  expectComplaint(replaced("spool_radius: 0.01", "spool_radius: 10"), {"spool_radius", "'10'", "m"});
  expectComplaint(replaced("spool_radius: 0.01", "spool_radius: ten"), {"spool_radius", "'ten'"});
  expectComplaint(replaced("spool_radius: 0.01", "spool_radius: .nan"), {"spool_radius"});
  expectComplaint(replaced("sign: 1", "sign: 2"), {"sign", "'2'", "-1"});
  expectComplaint(replaced("id: 2", "id: 253"), {"actuators[1].id", "'253'", "252"});
  expectComplaint(replaced("id: 2", "id: 1"), {"id", "twice"});
  expectComplaint(replaced("name: cable_2", "name: cable_1"), {"name", "twice"});
  expectComplaint(replaced("on_timeout: relax", "on_timeout: vent"), {"on_timeout", "'vent'", "hold or relax"});
  expectComplaint(replaced("method: present", "method: luck"), {"homing.method", "'luck'", "present or tension"});
  expectComplaint(replaced("method: present", "method: tension"), {"homing.tension", "nothing"});
  expectComplaint(replaced("dynamixel2", "dynamixel1"), {"protocol", "'dynamixel1'", "dynamixel2"});
  expectComplaint(replaced("displacement_max: 0.06", "displacement_max: -0.06"), {"displacement_max", "'-0.06'"});
  expectComplaint(replaced("bus_watchdog: 0.1", "bus_watchdog: 3"), {"bus_watchdog", "'3'"});
  expectComplaint(replaced("missing_limit: 10", "missing_limit: 1.5"), {"missing_limit", "1.5"});
}

TEST(HardwareDescription, AMisspeltKeyIsNotPassedOver) {
  expectComplaint(replaced("hold_limit: 0.5", "hold_limit: 0.5\n  relax_tme: 1"), {"hardware.relax_tme", "unknown"});
  expectComplaint(replaced("id: 2}", "id: 2, radius: 1}"), {"actuators[1].radius", "unknown"});
  expectComplaint(replaced("sign: 1,", "sign: 1, tension_mx: 3,"), {"hardware.servo.tension_mx", "unknown"});
}

TEST(HardwareDescription, BrokenYamlAndMissingFiles) {
  expectComplaint("hardware: [", {"robot.yaml"});
  EXPECT_THROW(HardwareDescription::load("/no/such/file.yaml"), ConfigError);
}

}  // namespace
}  // namespace sinew
