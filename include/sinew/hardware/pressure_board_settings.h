#pragma once

#include "sinew/common/yaml_reader.h"
#include "sinew/hardware/device_settings.h"
#include "sinew/hardware/pressure_message.h"

namespace sinew {

/// Where the pressure channel of one actuator is, and what its board is told about it.
struct PressureBoardSettings {
  int address = 1;  ///< of the board, 1 to 247
  int channel = 0;  ///< of the board, from 0
  /// Pa gauge: the board lets no set point pass it, and latches a fault and vents some percent of its range above. At
  /// least the actuator's own maximum.
  double pressure_limit = 0;
  /// What the board does by itself when nobody speaks to it: kVent or kSeal.
  PressureMode on_silence = PressureMode::kVent;

  /// Keys: `id`, `channel`, `pressure_limit` [Pa], `on_silence` (vent or seal; vent when missing). Throws
  /// ConfigError.
  static PressureBoardSettings read(const YamlReader& yaml);
};

/// An actuator as its board sees it.
struct PressureActuator {
  ActuatorBounds bounds;  ///< Pa gauge, Pa/s
  PressureBoardSettings settings;
};

}  // namespace sinew
