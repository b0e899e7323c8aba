#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/hardware/simulated_servo_bus.h"

namespace sinew {

/// One servo with a spool.
struct Winch {
  std::string actuator;    ///< name of the cable
  std::uint8_t id = 0;     ///< on the bus
  double reel_radius = 0;  ///< m of cable reeled in per rad of the shaft; negative when it reels in turning backwards
};

/// Cable reeled in [m per winch] by the shafts' present angles.
void calcReeledIn(const SimulatedServoBus& bus, const std::vector<Winch>& winches, VecX& reeled_in);

/// Lets cables under `tension` [N per winch] pull at their shafts. By virtual work, torque * angle = -tension * reeled
/// in.
void applyTension(const VecX& tension, const std::vector<Winch>& winches, SimulatedServoBus& bus);

}  // namespace sinew
