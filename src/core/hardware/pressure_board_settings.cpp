#include "sinew/hardware/pressure_board_settings.h"

namespace sinew {

PressureBoardSettings PressureBoardSettings::read(const YamlReader& yaml) {
  PressureBoardSettings s;
  s.address = yaml.integer("id", kMinPressureAddress, kMaxPressureAddress);
  s.channel = yaml.integer("channel", 0, kMaxPressureChannels - 1);
  s.pressure_limit = yaml.number("pressure_limit", 0, 1e7);
  s.on_silence = yaml.choiceOr("on_silence", {"vent", "seal"}, 0) == 0 ? PressureMode::kVent : PressureMode::kSeal;
  return s;
}

}  // namespace sinew
