#include "sinew/hardware/canopen_settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

const std::string kLeast = "id: 5\ncounts_per_turn: 4096\n";

CanopenSettings read(const std::string& text) {
  return CanopenSettings::read(YamlReader::fromText(text, "robot.yaml"));
}

std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "none";
}

void expectComplaint(const std::string& text, const std::string& key, const std::string& found) {
  const std::string said = complaint(text);
  EXPECT_NE(said.find("robot.yaml: " + key), std::string::npos) << said;
  EXPECT_NE(said.find(found), std::string::npos) << said;
}

TEST(CanopenSettings, TheLeastThatADriveNeeds) {
  const CanopenSettings s = read(kLeast);
  EXPECT_EQ(s.node, 5);
  EXPECT_EQ(s.driver_node, 127);
  EXPECT_EQ(s.counts_per_turn, 4096);
  EXPECT_EQ(s.gear, 1);
  EXPECT_FALSE(s.absolute_encoder);
  EXPECT_EQ(s.effort, CanopenEffort::kTorque);
  EXPECT_EQ(s.rated_unit, 1e-3);
  EXPECT_EQ(s.heartbeat, 0.1);
  EXPECT_TRUE(std::isinf(s.following_window) && std::isinf(s.limit_time));
  EXPECT_TRUE(s.hold_on_silence);
  EXPECT_TRUE(s.objects.empty());
  EXPECT_EQ(s.homing.method, 0);
}

TEST(CanopenSettings, Everything) {
  const CanopenSettings s = read(R"(
id: 9
driver_node: 1
vendor: 0xFB
product: 0xFFFFFFFF
counts_per_turn: 2048
gear: 4.8
absolute_encoder: true
effort: epos4_current
rated_unit: 1.0e-6
speed_unit: counts
heartbeat: 0.05
following_window: 0.01
limit_time: 2
on_silence: let_go
objects:
  - {index: 0x30A1, subindex: 0x01, type: u32, value: 0xFFFFFFFF}
  - {index: 0x6086, type: i16, value: -1}
  - {index: 0x2100, subindex: 3, type: i8, value: -128}
drive_homing: {method: -3, search_speed: 1, zero_speed: 0.1, acceleration: 5, timeout: 30}
)");
  EXPECT_EQ(s.vendor, 0xFBu);
  EXPECT_EQ(s.product, 0xFFFFFFFFu);
  EXPECT_EQ(s.effort, CanopenEffort::kEpos4Current);
  EXPECT_EQ(s.speed, CanopenSpeed::kCounts);
  EXPECT_FALSE(s.hold_on_silence);
  ASSERT_EQ(s.objects.size(), 3u);
  EXPECT_EQ(s.objects[0].index, 0x30A1);
  EXPECT_EQ(s.objects[0].size, 4);
  EXPECT_EQ(s.objects[0].value, 0xFFFFFFFFu);
  EXPECT_EQ(s.objects[1].size, 2);
  EXPECT_EQ(s.objects[1].value & 0xFFFF, 0xFFFFu);
  EXPECT_EQ(s.objects[2].value & 0xFF, 0x80u);
  EXPECT_EQ(s.homing.method, -3);
  EXPECT_EQ(s.homing.timeout, 30);
}

TEST(CanopenSettings, ComplaintsNameTheKeyAndWhatWasFound) {
  expectComplaint("counts_per_turn: 4096\n", "id", "nothing");
  expectComplaint("id: 128\ncounts_per_turn: 4096\n", "id", "'128'");
  expectComplaint("id: 5\n", "counts_per_turn", "nothing");
  expectComplaint(kLeast + "driver_node: 5\n", "driver_node", "another node");
  expectComplaint(kLeast + "vendor: 0x1FFFFFFFF\n", "vendor", "0x1FFFFFFFF");
  expectComplaint(kLeast + "gear: 0\n", "gear", "'0'");
  expectComplaint(kLeast + "effort: amps\n", "effort", "epos4_current");
  expectComplaint(kLeast + "heartbeat: 0\n", "heartbeat", "'0'");
  expectComplaint(kLeast + "on_silence: spin\n", "on_silence", "let_go");
  expectComplaint(kLeast + "following_window: -1\n", "following_window", "'-1'");
  const std::string object = kLeast + "objects:\n  - {index: ";
  expectComplaint(object + "0x100, type: u8, value: 1}\n", "objects[0].index", "0x1000");
  expectComplaint(object + "12q, type: u8, value: 1}\n", "objects[0].index", "'12q'");
  expectComplaint(object + "0x2000, type: u24, value: 1}\n", "objects[0].type", "'u24'");
  expectComplaint(object + "0x2000, value: 1}\n", "objects[0].type", "nothing");
  expectComplaint(object + "0x2000, type: u8, value: 256}\n", "objects[0].value", "0xFF");
  expectComplaint(object + "0x2000, type: i8, value: -129}\n", "objects[0].value", "-0x80");
  expectComplaint(object + "0x2000, type: u32, value: -1}\n", "objects[0].value", "'-1'");
  expectComplaint(object + "0x2000, type: u8, value: 1, sub: 1}\n", "objects[0].sub", "unknown");
  expectComplaint(object + "0x2000, type: u8, value: 99999999999999999999}\n", "objects[0].value",
                  "99999999999999999999");
  const std::string homing = kLeast + "drive_homing: {method: ";
  expectComplaint(homing + "0}\n", "drive_homing.method", "not 0");
  expectComplaint(homing + "17, search_speed: 1, zero_speed: 1, acceleration: 1}\n", "drive_homing.timeout", "nothing");
}

}  // namespace
}  // namespace sinew
