#include "sinew/hardware/simulated_odrive.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sinew {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr int kIdle = 1, kClosedLoop = 8;
constexpr int kPassThrough = 1, kTrapezoidal = 5;
constexpr std::uint32_t kFeeble = 0x200, kInverterHot = 0x4000, kWatchdog = 0x1000000, kStop = 0x2000000;

double clampAbs(double x, double limit) {
  return std::max(-limit, std::min(limit, x));
}

double floatAt(const CanFrame& f, std::size_t at) {
  unsigned char bytes[4];
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = f.data[at + i];  // a little-endian machine, as the device is
  float value = 0;
  std::memcpy(&value, bytes, 4);
  return static_cast<double>(value);
}

std::uint32_t integerAt(const CanFrame& f, std::size_t at) {
  return f.data[at] + 256u * (f.data[at + 1] + 256u * (f.data[at + 2] + 256u * f.data[at + 3]));
}

void write(CanFrame& f, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i, value /= 256) f.data[at + i] = static_cast<std::uint8_t>(value % 256);
}

void write(CanFrame& f, std::size_t at, double value) {
  const auto single = static_cast<float>(value);
  std::memcpy(&f.data[at], &single, 4);
}

// Firmware 0.5 has other bits.
std::uint32_t translate(std::uint32_t error) {
  std::uint32_t out = 0;
  if ((error & kWatchdog) != 0) out |= 0x800;
  if ((error & kStop) != 0) out |= 0x4000;
  if ((error & kInverterHot) != 0) out |= 0x40000;
  if ((error & ~(kWatchdog | kStop | kInverterHot)) != 0) out |= 0x40;
  return out;
}

}  // namespace

SimulatedOdrive::SimulatedOdrive(int node, const Parameters& parameters)
    : node_(node), parameters_(parameters), voltage_(parameters.supply) {
  boot();
}

void SimulatedOdrive::boot() {
  state_ = kIdle;
  error_ = disarm_reason_ = 0;
  control_mode_ = 3;
  input_mode_ = kPassThrough;
  input_pos_ = profile_velocity_ = profile_position_ = 0;
  velocity_limit_ = 2;
  current_limit_ = parameters_.current_max;
  profile_speed_ = 2;
  profile_acceleration_ = 0.5;
  watchdog_enabled_ = parameters_.watchdog_enabled;
  watchdog_setting_ = parameters_.watchdog_timeout;
  watchdog_timeout_ = watchdog_enabled_ ? watchdog_setting_ : 0;
  boot_angle_ = angle_;
  fed_at_ = beat_at_ = cyclic_at_ = {};
}

void SimulatedOdrive::restart() {
  boot();
  starting_ = true;
  start_at_ = {};
}

double SimulatedOdrive::turnsOf(double angle) const {
  return (angle - boot_angle_) * parameters_.gear_ratio / kTwoPi;
}

double SimulatedOdrive::angleOf(double turns) const {
  return boot_angle_ + turns * kTwoPi / parameters_.gear_ratio;
}

void SimulatedOdrive::disarm(std::uint32_t error) {
  error_ |= error;
  if (state_ == kClosedLoop) disarm_reason_ = error;
  state_ = kIdle;
}

void SimulatedOdrive::raise(std::uint32_t error) {
  disarm(error);
}

// --- The bus ---

void SimulatedOdrive::take(const CanFrame& frame, Time now, std::vector<CanFrame>& out) {
  if (!alive() || frame.extended || frame.id / 32 != static_cast<std::uint32_t>(node_)) return;
  fed_at_ = now;
  const int command = static_cast<int>(frame.id % 32);
  if (frame.remote)
    answer(command, out);
  else
    obey(command, frame, out);
}

void SimulatedOdrive::obey(int command, const CanFrame& frame, std::vector<CanFrame>& out) {
  const int size = frame.size;
  if (command == 0x02) disarm(kStop);
  if (command == 0x04 && size >= 4 && !parameters_.firmware05) accessEndpoint(frame, out);
  if (command == 0x07 && size >= 4) requestState(integerAt(frame, 0));
  if (command == 0x0B && size == 8) {
    control_mode_ = static_cast<int>(integerAt(frame, 0));
    input_mode_ = static_cast<int>(integerAt(frame, 4));
  }
  if (command == 0x0C && size == 8) input_pos_ = floatAt(frame, 0);
  if (command == 0x0F && size == 8) {
    velocity_limit_ = floatAt(frame, 0);
    current_limit_ = floatAt(frame, 4);
  }
  if (command == 0x11 && size >= 4) profile_speed_ = floatAt(frame, 0);
  if (command == 0x12 && size == 8) profile_acceleration_ = floatAt(frame, 0);
  if (command == 0x18) error_ = disarm_reason_ = 0;
}

void SimulatedOdrive::requestState(std::uint32_t state) {
  if (state == kIdle) state_ = kIdle;
  if (state != kClosedLoop || error_ != 0 || state_ == kClosedLoop) return;
  state_ = kClosedLoop;  // the set point stays as it is: a stale one moves the shaft now
  profile_position_ = turnsOf(angle_);
  profile_velocity_ = 0;
}

void SimulatedOdrive::accessEndpoint(const CanFrame& frame, std::vector<CanFrame>& out) {
  const unsigned endpoint = frame.data[1] + 256u * frame.data[2];
  const bool is_enable = endpoint != 0 && endpoint == parameters_.enable_endpoint;
  const bool is_timeout = endpoint != 0 && endpoint == parameters_.timeout_endpoint;
  if (!is_enable && !is_timeout) return;
  if (frame.data[0] == 1) {
    if (is_enable && frame.size >= 5) watchdog_enabled_ = frame.data[4] != 0;
    if (is_timeout && frame.size == 8) watchdog_setting_ = floatAt(frame, 4);
    watchdog_timeout_ = watchdog_enabled_ ? watchdog_setting_ : 0;
    return;
  }
  CanFrame reply;
  reply.id = static_cast<std::uint32_t>(node_) * 32 + 0x05;
  reply.size = is_enable ? 5 : 8;
  reply.data[1] = frame.data[1];
  reply.data[2] = frame.data[2];
  if (is_enable)
    reply.data[4] = watchdog_enabled_ ? 1 : 0;
  else
    write(reply, 4, watchdog_setting_);
  out.push_back(reply);
}

void SimulatedOdrive::answer(int command, std::vector<CanFrame>& out) {
  CanFrame f;
  f.id = static_cast<std::uint32_t>(node_ * 32 + command);
  f.size = 8;
  const bool old = parameters_.firmware05;
  if (command == 0x00 && !old) {
    f.data = {2, 4, 4, 58, 0, 6, 10, 0};
  } else if (command == 0x01) {
    write(f, 0, old ? translate(error_) : error_);
    f.data[4] = static_cast<std::uint8_t>(state_);
  } else if (command == 0x03) {
    write(f, 0, old ? 0 : error_);
    write(f, 4, old ? 0 : disarm_reason_);
  } else if (command == 0x09) {
    write(f, 0, turnsOf(angle_));
    write(f, 4, omega_ * parameters_.gear_ratio / kTwoPi);
  } else if (command == 0x14) {
    write(f, 0, current());
    write(f, 4, current());
  } else if (command == 0x15) {
    write(f, 0, old ? 0. : temperature_);
    write(f, 4, old ? 0. : temperature_ - 5);
  } else if (command == 0x17) {
    write(f, 0, voltage_);
    write(f, 4, 0.1);
  } else {
    return;
  }
  out.push_back(f);
}

void SimulatedOdrive::update(Time now, std::vector<CanFrame>& out) {
  if (starting_ && start_at_ == Time{}) start_at_ = now;
  if (starting_ && now - start_at_ >= duration(parameters_.boot_time)) starting_ = false;
  if (!alive()) return;
  const auto isDue = [now](Time& last, double period) {
    if (period <= 0 || now - last < duration(period)) return false;
    last = now;
    return true;
  };
  if (fed_at_ == Time{}) fed_at_ = now;
  const bool watched = watchdog_timeout_ > 0 && (state_ == kClosedLoop || parameters_.watchdog_idle);
  if (watched && now - fed_at_ > duration(watchdog_timeout_)) disarm(kWatchdog);
  if (isDue(beat_at_, parameters_.heartbeat)) answer(0x01, out);
  if (isDue(cyclic_at_, parameters_.cyclic))
    for (const int command : {0x09, 0x14, 0x17}) answer(command, out);
}

// --- Mechanics ---

void SimulatedOdrive::setSupplyVoltage(double voltage) {
  voltage_ = voltage;
  const bool powered = voltage >= parameters_.brown_out;
  if (powered && !powered_) restart();
  if (!powered) state_ = kIdle;
  powered_ = powered;
}

void SimulatedOdrive::setShaftAngle(double angle) {
  angle_ = angle;
}

void SimulatedOdrive::setLoadTorque(int, double torque) {
  load_ = torque;
}

double SimulatedOdrive::shaftAngle(int) const {
  return angle_;
}

double SimulatedOdrive::pressure(int) const {
  return 0;
}

void SimulatedOdrive::setLeak(int, double) {}

bool SimulatedOdrive::energised(int) const {
  return powered_ && state_ == kClosedLoop;
}

void SimulatedOdrive::step(double dt) {
  constexpr double kMaxStep = 1e-3;
  const int count = std::max(1, static_cast<int>(std::ceil(dt / kMaxStep - 1e-9)));
  for (int i = 0; i < count; ++i) substep(dt / count);
}

void SimulatedOdrive::substep(double dt) {
  if (frozen_) {
    omega_ = 0;
    return;
  }
  if (powered_ && voltage_ < parameters_.undervoltage) disarm(kFeeble);
  if (powered_ && temperature_ > parameters_.temperature_max) disarm(kInverterHot);
  torque_ = 0;
  double held = clampAbs(load_, parameters_.friction);
  if (energised(0)) {
    const double limit = current_limit_ * parameters_.torque_constant;
    torque_ = clampAbs(parameters_.damping * calcWantedSpeed(dt) - load_, limit);
    held = 0;  // what moves under torque has overcome the friction of its gear
  }
  omega_ = clampAbs((torque_ + load_ - held) / parameters_.damping, parameters_.speed_max);
  angle_ += omega_ * dt;
}

// rad/s of the spool towards the set point.
double SimulatedOdrive::calcWantedSpeed(double dt) {
  double goal = input_pos_;
  if (input_mode_ == kTrapezoidal) {
    const double distance = input_pos_ - profile_position_;
    const double braking = std::sqrt(2 * profile_acceleration_ * std::abs(distance));
    const double wanted = std::copysign(std::min(profile_speed_, braking), distance);
    profile_velocity_ += clampAbs(wanted - profile_velocity_, profile_acceleration_ * dt);
    const bool arriving = std::abs(distance) <= std::abs(profile_velocity_) * dt;
    profile_position_ = arriving ? input_pos_ : profile_position_ + profile_velocity_ * dt;
    if (arriving) profile_velocity_ = 0;
    goal = profile_position_;
  }
  const double limit = std::min(parameters_.speed_max, velocity_limit_ * kTwoPi / parameters_.gear_ratio);
  const double share = (1 - std::exp(-dt / parameters_.response_time)) / dt;
  return clampAbs((angleOf(goal) - angle_) * share, limit);
}

}  // namespace sinew
