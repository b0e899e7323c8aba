#include "sinew/hardware/canopen_units.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kPerMille = 1e-3;
constexpr double kAmperesPerUnit = 1e-3;  // of 3001:02 and 30D1:02
constexpr double kMaxUnsigned = std::numeric_limits<std::uint32_t>::max();
constexpr double kTiny = 1e-9;  // of a unit, by which rounding upwards may be off

double calcPerRating(const CanopenSettings& s, double torque_constant) {
  switch (s.effort) {
    case CanopenEffort::kTorque:
      return kPerMille * s.rated_unit * s.gear;
    case CanopenEffort::kCurrent:
      return kPerMille * s.rated_unit * torque_constant;
    default:
      return 0;
  }
}

std::uint32_t roundUp(double value) {
  return static_cast<std::uint32_t>(std::min(kMaxUnsigned, std::max(1., std::ceil(value - kTiny))));
}

}  // namespace

CanopenUnits::CanopenUnits(const CanopenSettings& s, const WinchDescription& cable)
    : radius_(cable.spool_radius),
      sign_(cable.sign),
      torque_constant_(cable.torque_constant),
      counts_per_radian_(s.counts_per_turn * s.gear / (kTwoPi)),
      rpm_unit_(kTwoPi / 60 / s.gear),
      per_rating_(calcPerRating(s, cable.torque_constant)),
      torque_unit_(kAmperesPerUnit * cable.torque_constant) {
  speed_unit_ = s.speed == CanopenSpeed::kRpm ? rpm_unit_ : 1 / counts_per_radian_;
}

void CanopenUnits::setZero(std::int32_t counts, double displacement) {
  zero_ = counts - sign_ * displacement / radius_ * counts_per_radian_;
}

double CanopenUnits::displacement(std::int32_t counts) const {
  return sign_ * (counts - zero_) / counts_per_radian_ * radius_;
}

bool CanopenUnits::canTell(double displacement) const {
  const double counts = zero_ + sign_ * displacement / radius_ * counts_per_radian_;
  return std::abs(counts) <= std::numeric_limits<std::int32_t>::max();
}

std::int32_t CanopenUnits::counts(double displacement) const {
  constexpr double kMax = std::numeric_limits<std::int32_t>::max();
  const double counts = zero_ + sign_ * displacement / radius_ * counts_per_radian_;
  return static_cast<std::int32_t>(std::lround(std::max(-kMax, std::min(kMax, counts))));
}

double CanopenUnits::tension(std::int32_t effort) const {
  return sign_ * effort * torque_unit_ / radius_;
}

double CanopenUnits::amperes(std::int32_t effort) const {
  return sign_ * effort * torque_unit_ / torque_constant_;
}

double CanopenUnits::effortLimit(double tension) const {
  return std::floor(tension * radius_ / torque_unit_ + kTiny);
}

std::uint32_t CanopenUnits::window(double displacement) const {
  return std::isinf(displacement) ? std::numeric_limits<std::uint32_t>::max()
                                  : roundUp(displacement / radius_ * counts_per_radian_);
}

std::uint32_t CanopenUnits::speed(double omega) const {
  return roundUp(omega / speed_unit_);
}

std::uint32_t CanopenUnits::rpm(double omega) const {
  return roundUp(omega / rpm_unit_);
}

}  // namespace sinew
