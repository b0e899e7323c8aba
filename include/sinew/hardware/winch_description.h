#pragma once

namespace sinew {

enum class HomingMethod {
  kPresent,  ///< the position found is displacement 0
  kTension,  ///< reel in slowly until the cable carries a tension: displacement 0
  kDevice    ///< the drive runs its own homing: where that ends is displacement 0
};

struct HomingDescription {
  HomingMethod method = HomingMethod::kPresent;
  double tension = 0;  ///< N at which the cable counts as taut
  double speed = 0;    ///< m/s of reeling in
  double travel = 0;   ///< m after which homing gives up
};

/// A cable on a spool on a motor's shaft.
struct WinchDescription {
  double spool_radius = 0;     ///< m
  int sign = 1;                ///< +1 when positive rotation reels in
  double torque_constant = 0;  ///< N m/A at the spool's shaft
  double tension_max = 0;      ///< N, bounded by the device itself
  HomingDescription homing;
};

}  // namespace sinew
