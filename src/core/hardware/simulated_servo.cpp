#include "sinew/hardware/simulated_servo.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sinew {
namespace {

namespace reg = servo_register;

constexpr std::size_t kEepromEnd = 64;

struct Field {
  ServoRegister at;
  bool writable;
  std::int32_t initial, min, max;
};

// Address, size, access, factory value and range of every field (e-Manual, XM430-W350).
constexpr Field kFields[] = {
    {reg::kModelNumber, false, kModelXm430W350, 0, 0},
    {{2, 4}, false, 0, 0, 0},
    {reg::kFirmwareVersion, false, 0, 0, 0},
    {reg::kId, true, 1, 0, kMaxServoId},
    {{8, 1}, true, 1, 0, 7},
    {reg::kReturnDelay, true, 250, 0, 254},
    {reg::kDriveMode, true, 0, 0, 13},
    {reg::kOperatingMode, true, 3, 0, 16},
    {{12, 1}, true, 255, 0, 255},
    {{13, 1}, true, 2, 1, 2},
    {reg::kHomingOffset, true, 0, -1044479, 1044479},
    {{24, 4}, true, 10, 0, 1023},
    {reg::kTemperatureLimit, true, 80, 0, 100},
    {reg::kMaxVoltageLimit, true, 160, 95, 160},
    {reg::kMinVoltageLimit, true, 95, 95, 160},
    {reg::kPwmLimit, true, 885, 0, 885},
    {reg::kCurrentLimit, true, 1193, 0, 1193},
    {{40, 4}, true, 32767, 0, 32767},
    {reg::kVelocityLimit, true, 350, 0, 1023},
    {reg::kMaxPositionLimit, true, 4095, 0, 4095},
    {reg::kMinPositionLimit, true, 0, 0, 4095},
    {reg::kShutdown, true, 52, 0, 63},
    {reg::kTorqueEnable, true, 0, 0, 1},
    {{65, 1}, true, 0, 0, 1},
    {reg::kStatusReturnLevel, true, 2, 0, 2},
    {reg::kRegisteredInstruction, false, 0, 0, 0},
    {reg::kHardwareError, false, 0, 0, 0},
    {{76, 2}, true, 1920, 0, 16383},
    {{78, 2}, true, 100, 0, 16383},
    {{80, 2}, true, 0, 0, 16383},
    {{82, 2}, true, 0, 0, 16383},
    {{84, 2}, true, 800, 0, 16383},
    {{88, 2}, true, 0, 0, 16383},
    {{90, 2}, true, 0, 0, 16383},
    {reg::kBusWatchdog, true, 0, 0, 127},
    {reg::kGoalPwm, true, 885, -885, 885},
    {reg::kGoalCurrent, true, 1193, -1193, 1193},
    {reg::kGoalVelocity, true, 0, -1023, 1023},
    {reg::kProfileAcceleration, true, 0, 0, 32767},
    {reg::kProfileVelocity, true, 0, 0, 32767},
    {reg::kGoalPosition, true, 0, -kMaxGoalPosition, kMaxGoalPosition},
    {reg::kRealtimeTick, false, 0, 0, 0},
    {reg::kMoving, false, 0, 0, 0},
    {reg::kMovingStatus, false, 0, 0, 0},
    {reg::kPresentPwm, false, 0, 0, 0},
    {reg::kPresentCurrent, false, 0, 0, 0},
    {reg::kPresentVelocity, false, 0, 0, 0},
    {reg::kPresentPosition, false, 0, 0, 0},
    {reg::kVelocityTrajectory, false, 0, 0, 0},
    {reg::kPositionTrajectory, false, 0, 0, 0},
    {reg::kPresentVoltage, false, 0, 0, 0},
    {reg::kPresentTemperature, false, 0, 0, 0},
};

constexpr std::size_t kIndirectAddresses = 168;  // 2 bytes each

const Field* findField(std::size_t address) {
  for (const Field& f : kFields)
    if (f.at.address == address) return &f;
  return nullptr;
}

bool isGoal(ServoRegister r) {
  return r.address >= reg::kGoalPwm.address && r.address <= reg::kGoalPosition.address &&
         r.address != reg::kProfileAcceleration.address && r.address != reg::kProfileVelocity.address;
}

double clampAbs(double x, double limit) {
  return std::max(-limit, std::min(limit, x));
}

}  // namespace

SimulatedServo::SimulatedServo(std::uint8_t id, const Parameters& parameters) : parameters_(parameters) {
  for (const Field& f : kFields) set(f.at, f.initial);
  set(reg::kId, id);
  set(reg::kFirmwareVersion, parameters.firmware);
  set(reg::kModelNumber, parameters.model);
  set(reg::kMinVoltageLimit, parameters.min_voltage);
  set(reg::kMaxVoltageLimit, parameters.max_voltage);
  set(reg::kCurrentLimit, parameters.current_limit);
  voltage_ = parameters.voltage;
  boot();
}

SimulatedServo::Parameters SimulatedServo::Parameters::makeXl330M288() {
  Parameters p;
  p.torque_constant = 0.52 / 1.47;
  p.stall_torque = 0.52;
  p.no_load_speed = 103 * 2 * kPi / 60;
  p.damping = 0.002;
  p.friction = 0.002;
  p.brown_out = 3;
  p.firmware = 48;
  p.model = 1200;
  p.amperes_per_unit = 1e-3;
  p.current_limit = 1750;
  p.min_voltage = 35;
  p.max_voltage = 70;
  p.voltage = 5;
  p.indirect_data = 208;
  p.indirect_count = 20;
  return p;
}

void SimulatedServo::set(ServoRegister r, std::int32_t value) {
  encodeRegister(value, r.size, &memory_[r.address]);
}

std::int32_t SimulatedServo::value(ServoRegister r) const {
  return decodeRegister(&memory_[r.address], r.size);
}

// Power-up: RAM at its defaults, the turns of the shaft forgotten.
void SimulatedServo::boot() {
  for (const Field& f : kFields)
    if (f.at.address >= kEepromEnd) set(f.at, f.initial);
  for (std::uint16_t i = 0; i < parameters_.indirect_count; ++i)
    encodeRegister(parameters_.indirect_data + i, 2, &memory_[kIndirectAddresses + 2u * i]);
  registered_size_ = 0;
  idle_time_ = 0;
  boot_milliseconds_ = milliseconds_;
  const int encoder = static_cast<int>(std::lround(angle_ / kRadiansPerCount)) * direction();
  zero_count_ = encoder - ((encoder % kCountsPerTurn) + kCountsPerTurn) % kCountsPerTurn;
  resetGoals();
  refreshPresent();
}

void SimulatedServo::reboot() {
  boot();
}

void SimulatedServo::resetGoals() {
  set(reg::kGoalPwm, value(reg::kPwmLimit));
  set(reg::kGoalCurrent, value(reg::kCurrentLimit));
  set(reg::kGoalVelocity, 0);
  set(reg::kGoalPosition, toCounts(angle_));
  profile_ = {angle_, 0};
}

int SimulatedServo::toCounts(double angle) const {
  return static_cast<int>(std::lround(angle / kRadiansPerCount)) * direction() - zero_count_ +
         value(reg::kHomingOffset);
}

double SimulatedServo::toAngle(int counts) const {
  return (counts - value(reg::kHomingOffset) + zero_count_) * direction() * kRadiansPerCount;
}

void SimulatedServo::setMilliseconds(std::int64_t ms) {
  milliseconds_ = ms;
}

std::uint8_t SimulatedServo::errorField(ServoError error) const {
  const bool alert = memory_[reg::kHardwareError.address] != 0;
  return static_cast<std::uint8_t>(static_cast<unsigned>(error) | (alert ? kAlertBit : 0u));
}

// Where the byte at `address` really lives: indirect data stands for the byte its indirect address names.
std::size_t SimulatedServo::resolve(std::size_t address) const {
  const std::size_t first = parameters_.indirect_data;
  if (address < first || address >= first + parameters_.indirect_count) return address;
  const std::uint8_t* p = &memory_[kIndirectAddresses + 2 * (address - first)];
  return static_cast<std::size_t>(p[0] | p[1] << 8);
}

bool SimulatedServo::inIndirectAddresses(std::size_t address) const {
  return address >= kIndirectAddresses && address < kIndirectAddresses + 2u * parameters_.indirect_count;
}

ServoError SimulatedServo::read(std::size_t address, std::size_t size, std::uint8_t* data) {
  if (address + size > kTableSize) return ServoError::kAccess;
  refreshPresent();
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t at = resolve(address + i);
    data[i] = at < kTableSize ? memory_[at] : std::uint8_t{0};
  }
  return ServoError::kNone;
}

ServoError SimulatedServo::checkValue(ServoRegister r, std::int32_t value) const {
  const Field* f = findField(r.address);
  if (value < f->min || value > f->max) return ServoError::kDataRange;
  if (isGoal(r) && watchdogTripped()) return ServoError::kDataRange;
  if (r.address == reg::kBusWatchdog.address && watchdogTripped() && value != 0) return ServoError::kDataRange;
  if (r.address == reg::kOperatingMode.address && value != 0 && value != 1 && value != 3 && value != 4 && value != 5 &&
      value != 16)
    return ServoError::kDataRange;
  const auto beyond = [&](ServoRegister limit) { return std::abs(value) > this->value(limit); };
  if (r.address == reg::kGoalCurrent.address && beyond(reg::kCurrentLimit)) return ServoError::kDataLimit;
  if (r.address == reg::kGoalVelocity.address && beyond(reg::kVelocityLimit)) return ServoError::kDataLimit;
  if (r.address == reg::kGoalPwm.address && beyond(reg::kPwmLimit)) return ServoError::kDataLimit;
  if (r.address == reg::kGoalPosition.address && mode() == OperatingMode::kPosition &&
      (value < this->value(reg::kMinPositionLimit) || value > this->value(reg::kMaxPositionLimit)))
    return ServoError::kDataLimit;
  const int alarms = this->value(reg::kHardwareError) & this->value(reg::kShutdown);
  if (r.address == reg::kTorqueEnable.address && value == 1 && alarms != 0) return ServoError::kResultFail;
  return ServoError::kNone;
}

ServoError SimulatedServo::checkWrite(std::size_t address, const std::uint8_t* data, std::size_t size) const {
  if (size == 0) return ServoError::kDataLength;
  for (std::size_t i = 0; i < size;) {
    const std::size_t at = resolve(address + i);
    if (at < kEepromEnd && torqueEnabled()) return ServoError::kAccess;
    if (inIndirectAddresses(at)) {
      if (torqueEnabled()) return ServoError::kAccess;
      if (at % 2 != 0 || i + 2 > size) return ServoError::kDataLength;
      i += 2;
      continue;
    }
    const Field* f = findField(at);
    if (f == nullptr || !f->writable) return ServoError::kAccess;
    if (i + f->at.size > size) return ServoError::kDataLength;
    const ServoError error = checkValue(f->at, decodeRegister(data + i, f->at.size));
    if (error != ServoError::kNone) return error;
    i += f->at.size;
  }
  return ServoError::kNone;
}

ServoError SimulatedServo::write(std::size_t address, const std::uint8_t* data, std::size_t size) {
  const ServoError error = checkWrite(address, data, size);
  if (error != ServoError::kNone) return error;
  for (std::size_t i = 0; i < size;) {
    const std::size_t at = resolve(address + i);
    if (inIndirectAddresses(at)) {
      std::memcpy(&memory_[at], data + i, 2);
      i += 2;
      continue;
    }
    const Field* f = findField(at);
    applyWrite(f->at, decodeRegister(data + i, f->at.size));
    i += f->at.size;
  }
  return ServoError::kNone;
}

void SimulatedServo::applyWrite(ServoRegister r, std::int32_t value) {
  const bool rising = r.address == reg::kTorqueEnable.address && value == 1 && !torqueEnabled();
  set(r, value);
  if (rising) {
    profile_ = {angle_, 0};  // the goals stay as they are: a stale one moves the shaft now
    idle_time_ = 0;
  }
  if (r.address == reg::kBusWatchdog.address) idle_time_ = 0;
  if (r.address == reg::kOperatingMode.address) resetGoals();
}

ServoError SimulatedServo::regWrite(std::size_t address, const std::uint8_t* data, std::size_t size) {
  if (size > registered_.size()) return ServoError::kDataLength;
  const ServoError error = checkWrite(address, data, size);
  if (error != ServoError::kNone) return error;
  std::copy(data, data + size, registered_.begin());
  registered_address_ = address;
  registered_size_ = size;
  set(reg::kRegisteredInstruction, 1);
  return ServoError::kNone;
}

ServoError SimulatedServo::action() {
  if (registered_size_ == 0) return ServoError::kInstruction;
  const std::size_t size = registered_size_;
  registered_size_ = 0;
  set(reg::kRegisteredInstruction, 0);
  return write(registered_address_, registered_.data(), size);
}

// Multi-turn reset: 01 44 58 4C 22, only at standstill.
ServoError SimulatedServo::clear(const std::uint8_t* parameters, std::size_t size) {
  constexpr std::uint8_t kKey[] = {0x01, 0x44, 0x58, 0x4C, 0x22};
  if (size != sizeof kKey || std::memcmp(parameters, kKey, sizeof kKey) != 0) return ServoError::kDataRange;
  if (std::abs(omega_) > kRadiansPerSecondPerUnit) return ServoError::kResultFail;
  const int encoder = static_cast<int>(std::lround(angle_ / kRadiansPerCount)) * direction();
  zero_count_ = encoder - ((encoder % kCountsPerTurn) + kCountsPerTurn) % kCountsPerTurn;
  set(reg::kGoalPosition, toCounts(angle_));
  profile_ = {angle_, 0};
  return ServoError::kNone;
}

void SimulatedServo::refreshPresent() {
  const int position = toCounts(angle_);
  const bool moving = std::abs(omega_) > value({24, 4}) * kRadiansPerSecondPerUnit;
  const bool arrived = std::abs(position - value(reg::kGoalPosition)) <= 2;
  set(reg::kRealtimeTick, static_cast<std::int32_t>((milliseconds_ - boot_milliseconds_) % kTickPeriod));
  set(reg::kMoving, moving ? 1 : 0);
  set(reg::kMovingStatus, arrived ? 1 : 0);
  const double volts = std::max(voltage_, 1e-3);
  const double pwm =
      (torque_ / parameters_.stall_torque + omega_ / parameters_.no_load_speed) * parameters_.voltage / volts;
  set(reg::kPresentPwm, static_cast<std::int32_t>(std::lround(885 * clampAbs(pwm, 1))) * direction());
  const double amperes = torque_ / parameters_.torque_constant;
  set(reg::kPresentCurrent,
      static_cast<std::int32_t>(std::lround(amperes / parameters_.amperes_per_unit)) * direction());
  set(reg::kPresentVelocity, static_cast<std::int32_t>(std::lround(omega_ / kRadiansPerSecondPerUnit)) * direction());
  set(reg::kPresentPosition, position);
  set(reg::kVelocityTrajectory,
      static_cast<std::int32_t>(std::lround(profile_.velocity / kRadiansPerSecondPerUnit)) * direction());
  set(reg::kPositionTrajectory, toCounts(profile_.position));
  set(reg::kPresentVoltage, static_cast<std::int32_t>(std::lround(voltage_ / kVoltsPerUnit)));
  set(reg::kPresentTemperature, static_cast<std::int32_t>(std::lround(temperature_)));
}

void SimulatedServo::setShaftAngle(double angle) {
  angle_ = angle;
  profile_ = {angle, 0};
}

void SimulatedServo::setSupplyVoltage(double voltage) {
  voltage_ = voltage;
  const bool powered = voltage >= parameters_.brown_out;
  if (powered && !powered_) boot();
  if (!powered) set(reg::kTorqueEnable, 0);
  powered_ = powered;
}

void SimulatedServo::step(double dt) {
  constexpr double kMaxStep = 1e-3;
  const int count = std::max(1, static_cast<int>(std::ceil(dt / kMaxStep - 1e-9)));
  for (int i = 0; i < count; ++i) substep(dt / count);
}

void SimulatedServo::substep(double dt) {
  if (frozen_) {
    omega_ = 0;
    return;
  }
  if (powered_) {
    updateWatchdog(dt);
    updateAlarms();
  }
  if (torqueEnabled()) {
    updateProfile(dt);
    torque_ = calcMotorTorque(dt);
  } else {
    torque_ = 0;
    profile_ = {angle_, 0};
  }
  // What moves the shaft under torque has already overcome the friction of its gear.
  const double held = torqueEnabled() ? 0 : clampAbs(load_, parameters_.friction);
  omega_ = clampAbs((torque_ + load_ - held) / parameters_.damping, parameters_.no_load_speed);
  angle_ += omega_ * dt;
}

// The device stops when no instruction packet has come for too long; its goals stay locked until 0 is written.
void SimulatedServo::updateWatchdog(double dt) {
  const int units = value(reg::kBusWatchdog);
  if (!torqueEnabled() || units == 0 || watchdogTripped()) return;
  idle_time_ += dt;
  if (idle_time_ <= units * kWatchdogUnit) return;
  memory_[reg::kBusWatchdog.address] = 0xFF;
  set(reg::kProfileAcceleration, 0);
  set(reg::kProfileVelocity, 0);
  set(reg::kGoalVelocity, 0);
  set(reg::kGoalPosition, toCounts(angle_));
  profile_ = {angle_, 0};
}

void SimulatedServo::updateAlarms() {
  int alarms = value(reg::kHardwareError);
  if (temperature_ > value(reg::kTemperatureLimit)) alarms |= kOverheating;
  const double min = value(reg::kMinVoltageLimit) * kVoltsPerUnit, max = value(reg::kMaxVoltageLimit) * kVoltsPerUnit;
  if (voltage_ < min || voltage_ > max) alarms |= kVoltageError;
  set(reg::kHardwareError, alarms);
  if ((alarms & value(reg::kShutdown)) != 0) set(reg::kTorqueEnable, 0);
}

// Trapezoid from the present profile state towards the goal (velocity override); 0 stands for no limit.
void SimulatedServo::updateProfile(double dt) {
  const double max_velocity = value(reg::kProfileVelocity) * kRadiansPerSecondPerUnit;
  const double max_acceleration = value(reg::kProfileAcceleration) * kRadiansPerSecond2PerUnit;
  if (mode() == OperatingMode::kVelocity) {
    const double goal = value(reg::kGoalVelocity) * kRadiansPerSecondPerUnit * direction();
    const double step = max_acceleration == 0 ? std::abs(goal - profile_.velocity) : max_acceleration * dt;
    profile_.velocity += clampAbs(goal - profile_.velocity, step);
    profile_.position = angle_;
    return;
  }
  const double goal = toAngle(value(reg::kGoalPosition));
  const double distance = goal - profile_.position;
  if (max_velocity == 0) {
    profile_ = {goal, 0};
  } else if (max_acceleration == 0) {
    const double move = clampAbs(distance, max_velocity * dt);
    profile_ = {profile_.position + move, move / dt};
  } else {
    const double braking = std::sqrt(2 * max_acceleration * std::abs(distance));
    const double wanted = std::copysign(std::min(max_velocity, braking), distance);
    profile_.velocity += clampAbs(wanted - profile_.velocity, max_acceleration * dt);
    const bool arriving = std::abs(distance) <= std::abs(profile_.velocity) * dt &&
                          std::abs(profile_.velocity) <= 2 * max_acceleration * dt;
    profile_ = arriving ? Motion{goal, 0} : Motion{profile_.position + profile_.velocity * dt, profile_.velocity};
  }
}

double SimulatedServo::torqueLimit() const {
  int units = value(reg::kCurrentLimit);
  if (mode() == OperatingMode::kCurrentBasedPosition) units = std::min(units, std::abs(value(reg::kGoalCurrent)));
  const double by_current = units * parameters_.amperes_per_unit * parameters_.torque_constant;
  const double by_voltage =
      parameters_.stall_torque * voltage_ / parameters_.voltage * std::abs(value(reg::kGoalPwm)) / 885.;
  return std::min(by_current, by_voltage);
}

double SimulatedServo::calcMotorTorque(double dt) const {
  if (mode() == OperatingMode::kCurrent) {
    const double amperes =
        watchdogTripped() ? 0 : value(reg::kGoalCurrent) * parameters_.amperes_per_unit * direction();
    return clampAbs(parameters_.torque_constant * amperes, torqueLimit());
  }
  if (mode() == OperatingMode::kPwm) {
    const double duty = watchdogTripped() ? 0 : value(reg::kGoalPwm) / 885. * direction();
    const double slope = parameters_.stall_torque / parameters_.no_load_speed;  // torque lost per rad/s
    const double omega =
        (duty * parameters_.stall_torque * voltage_ / parameters_.voltage + load_) / (parameters_.damping + slope);
    return parameters_.damping * omega - load_;
  }
  double omega = profile_.velocity;
  if (mode() != OperatingMode::kVelocity)
    omega = (profile_.position - angle_) * (1 - std::exp(-dt / parameters_.response_time)) / dt;
  return clampAbs(parameters_.damping * clampAbs(omega, maxSpeed()) - load_, torqueLimit());
}

}  // namespace sinew
