#include "sinew/hardware/odrive_settings.h"

#include "sinew/common/yaml_reader.h"

namespace sinew {

OdriveSettings OdriveSettings::read(const YamlReader& yaml) {
  OdriveSettings s;
  s.node = yaml.integer("id", 0, kMaxOdriveNode);
  s.firmware = yaml.choiceOr("firmware", {"0.5", "0.6"}, 1) == 0 ? OdriveFirmware::k05 : OdriveFirmware::k06;
  s.gear_ratio = yaml.positiveOr("gear_ratio", s.gear_ratio);
  if (yaml.choiceOr("input", {"pass_through", "trapezoidal"}, 0) == 1) {
    s.input = OdriveInput::kTrapezoidal;
    s.acceleration = yaml.positive("acceleration");
  }
  s.cyclic = yaml.choiceOr("feedback", {"request", "cyclic"}, 0) == 1;
  s.heartbeat = yaml.numberOr("heartbeat", s.heartbeat, 0.001, 10);
  s.voltage_min = yaml.numberOr("voltage_min", s.voltage_min, 0, 100);
  if (yaml.has("watchdog")) {
    if (s.firmware == OdriveFirmware::k05)
      yaml.fail("watchdog", "no endpoints: firmware 0.5 is set up with odrivetool");
    const YamlReader endpoints = yaml.map("watchdog");
    s.watchdog.given = true;
    s.watchdog.enable = static_cast<std::uint16_t>(endpoints.integer("enable_endpoint", 1, 65535));
    s.watchdog.timeout = static_cast<std::uint16_t>(endpoints.integer("timeout_endpoint", 1, 65535));
    endpoints.refuseUnknownKeys();
  }
  return s;
}

}  // namespace sinew
