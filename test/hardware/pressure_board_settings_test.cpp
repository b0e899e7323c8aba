#include "sinew/hardware/pressure_board_settings.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

PressureBoardSettings read(const std::string& text) {
  return PressureBoardSettings::read(YamlReader::fromText(text, "robot.yaml"));
}

std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(PressureBoardSettings, ReadsItsKeys) {
  const PressureBoardSettings s = read("{id: 12, channel: 3, pressure_limit: 60000, on_silence: seal}");
  EXPECT_EQ(s.address, 12);
  EXPECT_EQ(s.channel, 3);
  EXPECT_EQ(s.pressure_limit, 60000);
  EXPECT_EQ(s.on_silence, PressureMode::kSeal);
  EXPECT_EQ(read("{id: 1, channel: 0, pressure_limit: 1}").on_silence, PressureMode::kVent);
}

TEST(PressureBoardSettings, ComplaintsGiveTheKeyTheValueAndWhatIsRight) {
  const struct {
    const char* text;
    const char *key, *found, *expected;
  } cases[] = {
      {"{channel: 0, pressure_limit: 1}", "robot.yaml: id", "nothing", "1 to 247"},
      {"{id: 248, channel: 0, pressure_limit: 1}", "id", "248", "1 to 247"},
      {"{id: 1, channel: 16, pressure_limit: 1}", "channel", "16", "0 to 15"},
      {"{id: 1, channel: 0}", "pressure_limit", "nothing", "number"},
      {"{id: 1, channel: 0, pressure_limit: -5}", "pressure_limit", "-5", "0"},
      {"{id: 1, channel: 0, pressure_limit: 1, on_silence: hold}", "on_silence", "hold", "vent, seal"},
  };
  for (const auto& c : cases) {
    const std::string said = complaint(c.text);
    for (const char* part : {c.key, c.found, c.expected}) EXPECT_NE(said.find(part), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace sinew
