#include "sinew/hardware/servo_chain.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sinew {
namespace {

namespace reg = servo_register;

// The block that a cycle reads: these fields one after another, gathered by indirect addresses.
constexpr ServoRegister kGathered[] = {reg::kTorqueEnable,   reg::kBusWatchdog,       reg::kHardwareError,
                                       reg::kRealtimeTick,   reg::kPresentCurrent,    reg::kPresentPosition,
                                       reg::kPresentVoltage, reg::kPresentTemperature};
constexpr std::uint16_t kIndirectAddresses = 168;
constexpr std::uint16_t kIndirectData = 224;
constexpr std::uint8_t kBlockSize = 14;

constexpr int kTries = 3;                                     // of a set-up transaction on a bad line
constexpr double kRebootTime = 0.5;                           // s until a servo answers again
constexpr double kMinVoltage = 9.5;                           // V, the servo's own minimum
constexpr double kFreshness = 0.4;                            // of a period, by which a servo's clock may seem off
constexpr int kJumpCounts = 1024;                             // a quarter turn, plus ...
constexpr double kJumpCountsPerSecond = 2. * kCountsPerTurn;  // ... twice the speed of the fastest servo
constexpr double kSpeedMargin = 1.2;                          // of the servo's own profile over the driver's rate
constexpr std::uint8_t kFastFirmware = 45;                    // first to know fast sync read (e-Manual)
constexpr int kTripped = 0xFF;

void makeMap(std::uint8_t* map) {
  for (const ServoRegister& r : kGathered)
    for (std::uint16_t b = 0; b < r.size; ++b, map += 2) encodeRegister(r.address + b, 2, map);
}

// The value of a gathered field in a block.
std::int32_t field(const std::uint8_t* block, const ServoRegister& wanted) {
  for (const ServoRegister& r : kGathered) {
    if (r.address == wanted.address) return decodeRegister(block, r.size);
    block += r.size;
  }
  return 0;
}

const char* describe(std::uint32_t fault) {
  if ((fault & kServoSilent) != 0) return "does not answer";
  if ((fault & kServoUndervolted) != 0) return "had its supply dip, so its count of turns may be lost";
  if ((fault & kOverheating) != 0) return "is overheated";
  if ((fault & kOverload) != 0) return "is overloaded";
  if ((fault & 0xFF) != 0) return "reports a hardware error (register 70)";
  if ((fault & kServoJumped) != 0) return "jumped, so its count of turns is lost";
  if ((fault & kServoWatchdog) != 0) return "was stopped by its bus watchdog";
  return "is limp: it restarted or shut down";
}

}  // namespace

ServoChain::ServoChain(const HardwareDescription& h)
    : bus_(h.baud, duration(h.reply_timeout)),
      period_(1 / h.rate),
      watchdog_units_(static_cast<std::int32_t>(std::ceil(h.bus_watchdog / kWatchdogUnit - 1e-9))),
      missing_limit_(h.missing_limit),
      ids_(h.ids()),
      values_(ids_.size()),
      answers_(ids_.size()),
      readings_(ids_.size()) {
  for (const ActuatorDescription& a : h.actuators)
    servos_.push_back({CableTransmission(a.spool_radius, a.sign, a.torque_constant), a});
  some_ids_.reserve(ids_.size());
  some_values_.reserve(ids_.size());
  problem_.reserve(256);
  fresh_ = [this](std::size_t i, const std::uint8_t* data) { return isFresh(servos_[i], data); };
}

bool ServoChain::fail(std::size_t i, const std::string& what) {
  problem_ = servos_[i].description.name + " (id " + std::to_string(ids_[i]) + ") " + what;
  return false;
}

bool ServoChain::write(std::size_t i, ServoRegister r, std::int32_t value) {
  for (int n = 0; n < kTries; ++n) {
    const BusStatus status = bus_.write(ids_[i], r, value);
    if (status == BusStatus::kOk) return true;
    if (status == BusStatus::kDeviceError)
      return fail(i, "refuses " + std::to_string(value) + " for register " + std::to_string(r.address) + " (error " +
                         std::to_string(bus_.lastError() & ~kAlertBit) + ")");
  }
  return fail(i, describe(kServoSilent));
}

bool ServoChain::read(std::size_t i, ServoRegister r, std::int32_t& value) {
  for (int n = 0; n < kTries; ++n)
    if (bus_.read(ids_[i], r, value) == BusStatus::kOk) return true;
  return fail(i, describe(kServoSilent));
}

void ServoChain::startSetUp() {
  phase_ = Phase::kConfigure;
  next_ = 0;
  all_fast_ = true;
  problem_.clear();
  for (Servo& s : servos_) s.anchored = s.rebooting = false;
  for (ServoReading& r : readings_) {
    r.fault = 0;
    r.missing = 0;
  }
}

ServoChain::Progress ServoChain::updateSetUp(Time now) {
  if (phase_ == Phase::kConfigure) {
    const Progress progress = configure(next_, now);
    if (progress != Progress::kDone) return progress;
  } else if (!enable(next_)) {
    return Progress::kFailed;
  }
  if (++next_ < servos_.size()) return Progress::kBusy;
  next_ = 0;
  if (phase_ == Phase::kEnable) return Progress::kDone;
  phase_ = Phase::kEnable;
  bus_.setFastSyncRead(all_fast_);
  return Progress::kBusy;
}

ServoChain::Progress ServoChain::configure(std::size_t i, Time now) {
  Servo& s = servos_[i];
  if (s.rebooting && now - s.rebooted < duration(kRebootTime)) return Progress::kBusy;
  DynamixelBus::Identity identity;
  BusStatus status = BusStatus::kMissing;
  for (int n = 0; n < kTries && status != BusStatus::kOk; ++n) status = bus_.ping(ids_[i], identity);
  if (status != BusStatus::kOk) return fail(i, describe(kServoSilent)), Progress::kFailed;
  if (identity.model != kModelXm430W350 && identity.model != kModelXm430W210) {
    fail(i, "is of model " + std::to_string(identity.model) + ", expected 1020 (XM430-W350) or 1030 (XM430-W210)");
    return Progress::kFailed;
  }
  all_fast_ = all_fast_ && identity.firmware >= kFastFirmware;
  std::int32_t error = 0;
  if (!read(i, reg::kHardwareError, error)) return Progress::kFailed;
  if (error != 0 && s.rebooting) {
    fail(i, describe(static_cast<std::uint32_t>(error)));
    return Progress::kFailed;
  }
  if (error != 0) {  // only a restart clears an alarm
    bus_.reboot(ids_[i]);
    s.rebooting = true;
    s.rebooted = now;
    return Progress::kBusy;
  }
  return configureRegisters(i) ? Progress::kDone : Progress::kFailed;
}

// Touches torque only where a register demands it, so that recovering from a held position lets go of nothing.
bool ServoChain::configureRegisters(std::size_t i) {
  constexpr std::pair<ServoRegister, int> kWanted[] = {
      {reg::kReturnDelay, 0},
      {reg::kDriveMode, 0},
      {reg::kOperatingMode, static_cast<int>(OperatingMode::kCurrentBasedPosition)},
      {reg::kHomingOffset, 0},
      {reg::kStatusReturnLevel, 2}};
  for (const auto& wanted : kWanted) {
    std::int32_t found = 0;
    if (!read(i, wanted.first, found)) return false;
    if (found == wanted.second) continue;
    if (!write(i, reg::kTorqueEnable, 0) || !write(i, wanted.first, wanted.second)) return false;
    readings_[i].zero_valid = false;
  }
  bool mapped = false;
  if (!mapReading(i, mapped)) return false;
  if (!mapped) readings_[i].zero_valid = false;
  return true;
}

// `mapped`: whether the map was there already, that is, the servo has not restarted since it was set.
bool ServoChain::mapReading(std::size_t i, bool& mapped) {
  std::uint8_t wanted[2 * kBlockSize], found[2 * kBlockSize];
  makeMap(wanted);
  for (int n = 0; n < kTries; ++n) {
    if (bus_.readBlock(ids_[i], kIndirectAddresses, sizeof found, found) != BusStatus::kOk) continue;
    mapped = std::equal(wanted, wanted + sizeof wanted, found);
    if (mapped) return true;
    if (!write(i, reg::kTorqueEnable, 0)) return false;
    for (int m = 0; m < kTries; ++m)
      if (bus_.writeBlock(ids_[i], kIndirectAddresses, sizeof wanted, wanted) == BusStatus::kOk) return true;
  }
  return fail(i, "does not take its indirect addresses");
}

// The goal becomes the measured position before the torque comes on: nothing moves.
bool ServoChain::enable(std::size_t i) {
  Servo& s = servos_[i];
  const std::int32_t units = s.cable.goalCurrent(s.description.tension_max);
  std::int32_t current_limit = 0, position = 0, goal = 0, torque = 0, watchdog = 0;
  if (!read(i, reg::kCurrentLimit, current_limit)) return false;
  if (units < 1 || units > current_limit)
    return fail(i, "cannot bound its tension: tension_max needs a goal current of " + std::to_string(units) +
                       ", expected 1 to " + std::to_string(current_limit));
  if (!write(i, reg::kBusWatchdog, 0) || !read(i, reg::kPresentPosition, position)) return false;
  if (!write(i, reg::kProfileAcceleration, 0) ||
      !write(i, reg::kProfileVelocity, s.cable.profileVelocity(kSpeedMargin * s.description.rate_max)) ||
      !write(i, reg::kGoalCurrent, units) || !write(i, reg::kGoalPosition, position) ||
      !read(i, reg::kGoalPosition, goal))
    return false;
  if (goal != position) return fail(i, "did not take its present position as goal");
  if (!write(i, reg::kTorqueEnable, 1) || !write(i, reg::kBusWatchdog, watchdog_units_) ||
      !read(i, reg::kTorqueEnable, torque) || !read(i, reg::kBusWatchdog, watchdog))
    return false;
  if (torque != 1 || watchdog != watchdog_units_) return fail(i, "did not switch on with its bus watchdog armed");
  if (!readings_[i].zero_valid) s.cable.setZero(position);
  s.counts = position;
  readings_[i].displacement = s.cable.displacement(position);
  return true;
}

void ServoChain::setZero(int i, double displacement) {
  const auto k = static_cast<std::size_t>(i);
  servos_[k].cable.setZero(servos_[k].counts, displacement);
  readings_[k].displacement = displacement;
  readings_[k].zero_valid = true;
}

bool ServoChain::writeSetPoints(const std::vector<double>& displacement) {
  for (std::size_t i = 0; i < servos_.size(); ++i) values_[i] = servos_[i].cable.counts(displacement[i]);
  return bus_.syncWrite(reg::kGoalPosition, ids_, values_) != BusStatus::kClosed;
}

bool ServoChain::writeTensionLimits(const std::vector<double>& tension) {
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const double limit = std::min(std::max(tension[i], 0.), servos_[i].description.tension_max);
    values_[i] = servos_[i].cable.goalCurrent(limit);
  }
  return bus_.syncWrite(reg::kGoalCurrent, ids_, values_) != BusStatus::kClosed;
}

bool ServoChain::release(const std::vector<bool>& which) {
  some_ids_.clear();
  some_values_.clear();
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (!which[i]) continue;
    some_ids_.push_back(ids_[i]);
    some_values_.push_back(0);
  }
  return bus_.syncWrite(reg::kTorqueEnable, some_ids_, some_values_) != BusStatus::kClosed;
}

bool ServoChain::read(Time now) {
  for (ServoReading& r : readings_) r.valid = false;
  asked_ = now;
  const BusStatus status = bus_.syncRead(kIndirectData, kBlockSize, ids_, answers_, fresh_);
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    if (answers_[i].status == BusStatus::kOk) take(i, answers_[i]);
    ServoReading& r = readings_[i];
    r.missing = r.valid ? 0 : r.missing + 1;
    if (r.missing >= missing_limit_) r.fault |= kServoSilent;
  }
  return status != BusStatus::kClosed;
}

// Answers 0 V only when the map of indirect addresses is gone: the servo has restarted, and `take` says so.
bool ServoChain::isFresh(const Servo& servo, const std::uint8_t* data) const {
  if (!servo.anchored || field(data, reg::kPresentVoltage) == 0) return true;
  const double elapsed = 1e3 * seconds(asked_ - servo.read_at), slack = 1e3 * kFreshness * period_ + 1;
  const double advance = (field(data, reg::kRealtimeTick) - servo.tick + kTickPeriod) % kTickPeriod;
  const double off = std::remainder(advance - elapsed, static_cast<double>(kTickPeriod));
  return std::abs(off) <= slack + 1e-3 * elapsed;
}

void ServoChain::take(std::size_t i, const SyncAnswer& answer) {
  Servo& s = servos_[i];
  ServoReading& r = readings_[i];
  const std::uint8_t* data = answer.data.data();
  const int error = field(data, reg::kHardwareError), counts = field(data, reg::kPresentPosition);
  if (field(data, reg::kTorqueEnable) == 0) r.fault |= kServoLimp;
  if (field(data, reg::kPresentVoltage) == 0) return;
  r.valid = true;
  r.fault |= static_cast<std::uint32_t>(error);
  if (field(data, reg::kBusWatchdog) == kTripped) r.fault |= kServoWatchdog;
  r.current = s.cable.amperes(field(data, reg::kPresentCurrent));
  r.tension = s.cable.tension(field(data, reg::kPresentCurrent));
  r.voltage = field(data, reg::kPresentVoltage) * kVoltsPerUnit;
  r.temperature = field(data, reg::kPresentTemperature);
  const double elapsed = s.anchored ? seconds(asked_ - s.read_at) : 0;
  if (s.anchored && std::abs(counts - s.counts) > kJumpCounts + kJumpCountsPerSecond * elapsed) r.fault |= kServoJumped;
  if (r.voltage < kMinVoltage || (error & kVoltageError) != 0) r.fault |= kServoUndervolted;
  if ((r.fault & (kServoJumped | kServoUndervolted)) != 0) r.zero_valid = false;
  s.counts = counts;
  s.tick = field(data, reg::kRealtimeTick);
  s.read_at = asked_;
  s.anchored = true;
  r.displacement = s.cable.displacement(counts);
}

bool ServoChain::zerosValid() const {
  return std::all_of(readings_.begin(), readings_.end(), [](const ServoReading& r) { return r.zero_valid; });
}

bool ServoChain::checkHealth() {
  for (std::size_t i = 0; i < readings_.size(); ++i)
    if (readings_[i].fault != 0) return fail(i, describe(readings_[i].fault));
  return true;
}

}  // namespace sinew
