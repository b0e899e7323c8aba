#include "sinew/hardware/cable_transmission.h"

#include <cmath>

#include "sinew/hardware/servo_registers.h"

namespace sinew {

CableTransmission::CableTransmission(double radius, int sign, double torque_constant)
    : radius_(radius), sign_(sign), torque_constant_(torque_constant) {}

double CableTransmission::resolution() const {
  return radius_ * kRadiansPerCount;
}

void CableTransmission::setZero(std::int32_t counts, double displacement) {
  zero_ = counts - sign_ * displacement / resolution();
}

double CableTransmission::displacement(std::int32_t counts) const {
  return sign_ * (counts - zero_) * resolution();
}

std::int32_t CableTransmission::counts(double displacement) const {
  return static_cast<std::int32_t>(std::lround(zero_ + sign_ * displacement / resolution()));
}

double CableTransmission::amperes(std::int32_t current) const {
  return sign_ * current * current_unit_;
}

double CableTransmission::tension(std::int32_t current) const {
  return amperes(current) * torque_constant_ / radius_;
}

std::int32_t CableTransmission::goalCurrent(double tension) const {
  return static_cast<std::int32_t>(std::floor(tension * radius_ / torque_constant_ / current_unit_));
}

std::int32_t CableTransmission::profileVelocity(double speed) const {
  return static_cast<std::int32_t>(std::ceil(speed / radius_ / kRadiansPerSecondPerUnit));
}

}  // namespace sinew
