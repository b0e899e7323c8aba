#pragma once

#include <cstdint>

#include "sinew/hardware/canopen_settings.h"
#include "sinew/hardware/winch_description.h"

namespace sinew {

/// From a drive's numbers to the cable on its spool. Displacement is the length pulled in.
///   counts = zero + sign * displacement / radius * counts per radian of the spool,
///   tension = sign * torque / radius
class CanopenUnits {
 public:
  CanopenUnits(const CanopenSettings& settings, const WinchDescription& cable);

  /// Whether efforts count in parts of a rating (6075 or 6076), which then has to be read first.
  bool needsRating() const { return per_rating_ > 0; }
  /// The rating as the drive tells it, above 0.
  void setRating(std::uint32_t rating) { torque_unit_ = per_rating_ * rating; }
  /// Makes `displacement` [m] belong to the position `counts`.
  void setZero(std::int32_t counts, double displacement);

  double displacement(std::int32_t counts) const;   ///< m
  std::int32_t counts(double displacement) const;   ///< nearest that a drive can be told
  bool canTell(double displacement) const;          ///< whether 32 bits are enough for it
  double tension(std::int32_t effort) const;        ///< N
  double amperes(std::int32_t effort) const;        ///< A, positive while reeling in
  double effortLimit(double tension) const;         ///< whole units that never exceed `tension` [N]
  std::uint32_t window(double displacement) const;  ///< counts, at least `displacement` [m]; all ones when infinite
  std::uint32_t speed(double omega) const;          ///< in the drive's unit, at least `omega` [rad/s of the spool]
  std::uint32_t rpm(double omega) const;            ///< of the motor, at least `omega` [rad/s of the spool]
  double countsPerRadian() const { return counts_per_radian_; }  ///< of the spool
  double radius() const { return radius_; }                      ///< m

 private:
  double radius_;
  int sign_;
  double torque_constant_;
  double counts_per_radian_;
  double speed_unit_, rpm_unit_;  // rad/s of the spool
  double per_rating_;             // N m of the spool per unit of effort and unit of rating; 0 without rating
  double torque_unit_;            // N m of the spool per unit of effort
  double zero_ = 0;               // counts at displacement 0
};

}  // namespace sinew
