#pragma once

#include <cstddef>
#include <cstdint>

namespace sinew {

/// A field of a servo's control table.
struct ServoRegister {
  std::uint16_t address;
  std::uint8_t size;  ///< bytes, little-endian, two's complement where signed
};

/// Control table of the XM430-W350 and its relatives of the X series, after ROBOTIS' e-Manual
/// (emanual.robotis.com/docs/en/dxl/x/xm430-w350).
namespace servo_register {
constexpr ServoRegister kModelNumber{0, 2};
constexpr ServoRegister kFirmwareVersion{6, 1};
constexpr ServoRegister kId{7, 1};
constexpr ServoRegister kReturnDelay{9, 1};  // 2 us
constexpr ServoRegister kDriveMode{10, 1};
constexpr ServoRegister kOperatingMode{11, 1};
constexpr ServoRegister kHomingOffset{20, 4};      // counts
constexpr ServoRegister kTemperatureLimit{31, 1};  // degC
constexpr ServoRegister kMaxVoltageLimit{32, 2};   // 0.1 V
constexpr ServoRegister kMinVoltageLimit{34, 2};   // 0.1 V
constexpr ServoRegister kPwmLimit{36, 2};
constexpr ServoRegister kCurrentLimit{38, 2};  // 2.69 mA
constexpr ServoRegister kVelocityLimit{44, 4};
constexpr ServoRegister kMaxPositionLimit{48, 4};
constexpr ServoRegister kMinPositionLimit{52, 4};
constexpr ServoRegister kShutdown{63, 1};
constexpr ServoRegister kTorqueEnable{64, 1};
constexpr ServoRegister kStatusReturnLevel{68, 1};
constexpr ServoRegister kRegisteredInstruction{69, 1};
constexpr ServoRegister kHardwareError{70, 1};
constexpr ServoRegister kBusWatchdog{98, 1};  // 20 ms, -1 tripped
constexpr ServoRegister kGoalPwm{100, 2};
constexpr ServoRegister kGoalCurrent{102, 2};
constexpr ServoRegister kGoalVelocity{104, 4};
constexpr ServoRegister kProfileAcceleration{108, 4};  // 214.577 rev/min2
constexpr ServoRegister kProfileVelocity{112, 4};
constexpr ServoRegister kGoalPosition{116, 4};
constexpr ServoRegister kRealtimeTick{120, 2};  // ms, wraps at 32768
constexpr ServoRegister kMoving{122, 1};
constexpr ServoRegister kMovingStatus{123, 1};
constexpr ServoRegister kPresentPwm{124, 2};
constexpr ServoRegister kPresentCurrent{126, 2};
constexpr ServoRegister kPresentVelocity{128, 4};
constexpr ServoRegister kPresentPosition{132, 4};
constexpr ServoRegister kVelocityTrajectory{136, 4};
constexpr ServoRegister kPositionTrajectory{140, 4};
constexpr ServoRegister kPresentVoltage{144, 2};      // 0.1 V
constexpr ServoRegister kPresentTemperature{146, 1};  // degC
}  // namespace servo_register

enum class OperatingMode : std::uint8_t {
  kCurrent = 0,
  kVelocity = 1,
  kPosition = 3,
  kExtendedPosition = 4,
  kCurrentBasedPosition = 5,
  kPwm = 16
};

/// Bits of the hardware error register.
enum HardwareErrorBit : std::uint8_t {
  kVoltageError = 1 << 0,
  kHallError = 1 << 1,
  kOverheating = 1 << 2,
  kEncoderError = 1 << 3,
  kElectricalShock = 1 << 4,
  kOverload = 1 << 5
};

constexpr double kPi = 3.14159265358979323846;
constexpr int kCountsPerTurn = 4096;
constexpr double kRadiansPerCount = 2 * kPi / kCountsPerTurn;
constexpr double kAmperesPerUnit = 2.69e-3;
constexpr double kRadiansPerSecondPerUnit = 0.229 * 2 * kPi / 60;              // velocity registers, 0.229 rev/min
constexpr double kRadiansPerSecond2PerUnit = 214.577 * 2 * kPi / (60. * 60.);  // profile acceleration
constexpr double kVoltsPerUnit = 0.1;
constexpr double kWatchdogUnit = 0.02;     // s
constexpr double kReturnDelayUnit = 2e-6;  // s
constexpr int kTickPeriod = 32768;         // ms
constexpr int kMaxGoalPosition = 1048575;  // counts, extended and current-based position modes
constexpr std::uint16_t kModelXm430W350 = 1020;
constexpr std::uint16_t kModelXm430W210 = 1030;

/// A register's value from its bytes, sign-extended for 2 and 4 bytes, unsigned for 1.
inline std::int32_t decodeRegister(const std::uint8_t* data, std::size_t size) {
  if (size == 1) return data[0];
  if (size == 2) return static_cast<std::int16_t>(data[0] | data[1] << 8);
  return static_cast<std::int32_t>(data[0] | data[1] << 8 | data[2] << 16 | static_cast<std::uint32_t>(data[3]) << 24);
}

inline void encodeRegister(std::int32_t value, std::size_t size, std::uint8_t* data) {
  for (std::size_t i = 0; i < size; ++i)
    data[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> (8 * i));
}

}  // namespace sinew
