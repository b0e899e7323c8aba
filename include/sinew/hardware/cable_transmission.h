#pragma once

#include <cstdint>

namespace sinew {

/// From a servo to the cable on its spool. Displacement is the length pulled in; `sign` is +1 when positive rotation of
/// the servo reels in, -1 otherwise.
///   counts = zero + sign * displacement / radius / (2 pi / 4096),   tension = sign * torque constant * current /
///   radius
class CableTransmission {
 public:
  /// Radius of the spool [m], +1 or -1, torque constant [N m/A] at the spool's shaft.
  CableTransmission(double radius, int sign, double torque_constant);

  /// A per unit of the current registers, 2.69 mA unless told otherwise.
  void setCurrentUnit(double amperes) { current_unit_ = amperes; }
  void restoreZero(double counts) { zero_ = counts; }
  /// Makes `displacement` [m] belong to the position `counts`.
  void setZero(std::int32_t counts, double displacement = 0);

  double zero() const { return zero_; }              ///< counts at displacement 0
  double displacement(std::int32_t counts) const;    ///< m
  std::int32_t counts(double displacement) const;    ///< nearest
  double tension(std::int32_t current) const;        ///< N, from the present-current register
  double amperes(std::int32_t current) const;        ///< A, positive while reeling in
  std::int32_t goalCurrent(double tension) const;    ///< register units that never exceed `tension` [N]
  std::int32_t profileVelocity(double speed) const;  ///< register units, at least `speed` [m/s]
  double resolution() const;                         ///< m per count

 private:
  double radius_;
  int sign_;
  double torque_constant_;
  double current_unit_ = 2.69e-3;  // A
  double zero_ = 0;                // counts at displacement 0
};

}  // namespace sinew
