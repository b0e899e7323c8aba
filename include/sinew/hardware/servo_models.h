#pragma once

#include <cstdint>

namespace sinew {

/// What tells one model of Dynamixel X from another, where the driver cares. Every model here has the current-based
/// position mode, by which the servo itself bounds a cable's tension.
struct ServoModel {
  std::uint16_t number;  ///< as it answers a ping
  const char* name;
  double amperes_per_unit;         ///< A, of goal and present current
  double min_voltage;              ///< V, below which the supply has dipped
  std::uint16_t indirect_address;  ///< of the first indirect address, 2 bytes each
  std::uint16_t indirect_data;     ///< of the first byte seen through them
};

/// The model with `number`; nullptr when the driver does not know it, or when it cannot bound its current.
const ServoModel* findServoModel(std::uint16_t number);

/// Numbers and names of all, for messages.
const char* listServoModels();

}  // namespace sinew
