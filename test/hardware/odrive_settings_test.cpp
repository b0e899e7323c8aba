#include "sinew/hardware/odrive_settings.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"
#include "sinew/common/yaml_reader.h"

namespace sinew {
namespace {

OdriveSettings read(const std::string& text) {
  const YamlReader yaml = YamlReader::fromText(text, "robot.yaml");
  const OdriveSettings settings = OdriveSettings::read(yaml);
  yaml.refuseUnknownKeys();
  return settings;
}

std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(OdriveSettings, OnlyTheNodeIsRequired) {
  const OdriveSettings s = read("id: 3");
  EXPECT_EQ(s.node, 3);
  EXPECT_EQ(s.firmware, OdriveFirmware::k06);
  EXPECT_EQ(s.gear_ratio, 1);
  EXPECT_EQ(s.input, OdriveInput::kPassThrough);
  EXPECT_FALSE(s.cyclic);
  EXPECT_FALSE(s.watchdog.given);
}

TEST(OdriveSettings, ReadsEveryKey) {
  const OdriveSettings s = read(
      "{id: 62, firmware: '0.6', gear_ratio: 8, input: trapezoidal, acceleration: 0.5, feedback: cyclic,"
      " heartbeat: 0.02, voltage_min: 20, watchdog: {enable_endpoint: 268, timeout_endpoint: 269}}");
  EXPECT_EQ(s.gear_ratio, 8);
  EXPECT_EQ(s.input, OdriveInput::kTrapezoidal);
  EXPECT_EQ(s.acceleration, 0.5);
  EXPECT_TRUE(s.cyclic);
  EXPECT_EQ(s.heartbeat, 0.02);
  EXPECT_EQ(s.voltage_min, 20);
  EXPECT_TRUE(s.watchdog.given);
  EXPECT_EQ(s.watchdog.enable, 268);
  EXPECT_EQ(s.watchdog.timeout, 269);
}

TEST(OdriveSettings, ComplainsByName) {
  const std::pair<const char*, const char*> cases[] = {
      {"gear_ratio: 2", "robot.yaml: id"},
      {"id: 63", "0 to 62"},
      {"{id: 1, firmware: '0.4'}", "firmware"},
      {"{id: 1, input: trapezoidal}", "acceleration"},
      {"{id: 1, acceleration: 1}", "acceleration"},
      {"{id: 1, gear_ratio: 0}", "gear_ratio"},
      {"{id: 1, firmware: '0.5', watchdog: {enable_endpoint: 1, timeout_endpoint: 2}}", "odrivetool"},
      {"{id: 1, watchdog: {enable_endpoint: 1}}", "watchdog.timeout_endpoint"},
      {"{id: 1, watchdog: {enable_endpoint: 1, timeout_endpoint: 2, x: 1}}", "watchdog.x"}};
  for (const auto& c : cases) EXPECT_NE(complaint(c.first).find(c.second), std::string::npos) << complaint(c.first);
}

}  // namespace
}  // namespace sinew
