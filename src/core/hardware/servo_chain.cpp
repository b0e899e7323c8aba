#include "sinew/hardware/servo_chain.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "sinew/hardware/actuator_fault.h"

namespace sinew {
namespace {

namespace reg = servo_register;

// The block that a cycle reads: these fields one after another, gathered by indirect addresses.
constexpr ServoRegister kGathered[] = {reg::kTorqueEnable,   reg::kBusWatchdog,       reg::kHardwareError,
                                       reg::kRealtimeTick,   reg::kPresentCurrent,    reg::kPresentPosition,
                                       reg::kPresentVoltage, reg::kPresentTemperature};
constexpr std::uint8_t kBlockSize = 14;

constexpr int kTries = 3;                                     // of a set-up transaction on a bad line
constexpr double kRebootTime = 0.5;                           // s until a servo answers again
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

constexpr const char* kSilent = "does not answer";

}  // namespace

ServoChain::ServoChain(const HardwareDescription& h, int bus, LineFactory open_line)
    : open_line_(std::move(open_line)),
      bus_(h.buses[static_cast<std::size_t>(bus)].baud, duration(h.timing(bus).reply_timeout)),
      period_(1 / h.rate),
      watchdog_units_(static_cast<std::int32_t>(std::ceil(h.bus_watchdog / kWatchdogUnit - 1e-9))),
      missing_limit_(h.timing(bus).missing_limit) {
  for (const int i : h.actuatorsOn(bus)) {
    const ActuatorDescription& a = h.actuators[static_cast<std::size_t>(i)];
    servos_.push_back({CableTransmission(a.cable.spool_radius, a.cable.sign, a.cable.torque_constant), a});
    ids_.push_back(static_cast<std::uint8_t>(a.id));
  }
  values_.resize(ids_.size());
  readings_.resize(ids_.size());
  some_ids_.reserve(ids_.size());
  some_values_.reserve(ids_.size());
  problem_.reserve(256);
}

bool ServoChain::open(std::string& why) {
  why = "no line";
  line_ = open_line_(why);
  bus_.attach(line_.get());
  return line_ != nullptr;
}

void ServoChain::close() {
  bus_.attach(nullptr);
  line_.reset();
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
  return fail(i, kSilent);
}

bool ServoChain::read(std::size_t i, ServoRegister r, std::int32_t& value) {
  for (int n = 0; n < kTries; ++n)
    if (bus_.read(ids_[i], r, value) == BusStatus::kOk) return true;
  return fail(i, kSilent);
}

void ServoChain::startSetUp(bool /*home_all*/) {
  phase_ = Phase::kConfigure;
  next_ = 0;
  all_fast_ = true;
  problem_.clear();
  for (Servo& s : servos_) s.anchored = s.rebooting = false;
  for (ActuatorReading& r : readings_) {
    r.fault = 0;
    r.missing = 0;
  }
}

SetUpProgress ServoChain::updateSetUp(Time now) {
  if (phase_ == Phase::kConfigure) {
    const SetUpProgress progress = configure(next_, now);
    if (progress != SetUpProgress::kDone) return progress;
  } else if (!enable(next_)) {
    return SetUpProgress::kFailed;
  }
  if (++next_ < servos_.size()) return SetUpProgress::kBusy;
  next_ = 0;
  if (phase_ == Phase::kEnable) return SetUpProgress::kDone;
  phase_ = Phase::kEnable;
  makeReadGroups();
  bus_.setFastSyncRead(all_fast_);
  return SetUpProgress::kBusy;
}

SetUpProgress ServoChain::configure(std::size_t i, Time now) {
  Servo& s = servos_[i];
  if (s.rebooting && now - s.rebooted < duration(kRebootTime)) return SetUpProgress::kBusy;
  if (!identify(i)) return SetUpProgress::kFailed;
  std::int32_t error = 0;
  if (!read(i, reg::kHardwareError, error)) return SetUpProgress::kFailed;
  if (error != 0 && s.rebooting) {
    fail(i, describeFault(static_cast<std::uint32_t>(error)));
    return SetUpProgress::kFailed;
  }
  if (error != 0) {  // only a restart clears an alarm
    bus_.reboot(ids_[i]);
    s.rebooting = true;
    s.rebooted = now;
    return SetUpProgress::kBusy;
  }
  return configureRegisters(i) ? SetUpProgress::kDone : SetUpProgress::kFailed;
}

bool ServoChain::identify(std::size_t i) {
  DynamixelBus::Identity identity;
  BusStatus status = BusStatus::kMissing;
  for (int n = 0; n < kTries && status != BusStatus::kOk; ++n) status = bus_.ping(ids_[i], identity);
  if (status != BusStatus::kOk) return fail(i, kSilent);
  Servo& s = servos_[i];
  s.model = findServoModel(identity.model);
  if (s.model == nullptr)
    return fail(i, "is of model " + std::to_string(identity.model) + ", expected one of " + listServoModels());
  s.cable.setCurrentUnit(s.model->amperes_per_unit);
  all_fast_ = all_fast_ && identity.firmware >= kFastFirmware;
  return true;
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
    readings_[i].zero_valid = servos_[i].remembered = false;
  }
  bool mapped = false;
  if (!mapReading(i, mapped)) return false;
  readings_[i].zero_valid = mapped && (readings_[i].zero_valid || servos_[i].remembered);
  servos_[i].remembered = false;
  return true;
}

// `mapped`: whether the map was there already, that is, the servo has not restarted since it was set.
bool ServoChain::mapReading(std::size_t i, bool& mapped) {
  std::uint8_t wanted[2 * kBlockSize], found[2 * kBlockSize];
  makeMap(wanted);
  for (int n = 0; n < kTries; ++n) {
    if (bus_.readBlock(ids_[i], servos_[i].model->indirect_address, sizeof found, found) != BusStatus::kOk) continue;
    mapped = std::equal(wanted, wanted + sizeof wanted, found);
    if (mapped) return true;
    if (!write(i, reg::kTorqueEnable, 0)) return false;
    for (int m = 0; m < kTries; ++m)
      if (bus_.writeBlock(ids_[i], servos_[i].model->indirect_address, sizeof wanted, wanted) == BusStatus::kOk)
        return true;
  }
  return fail(i, "does not take its indirect addresses");
}

// The goal becomes the measured position before the torque comes on: nothing moves.
bool ServoChain::enable(std::size_t i) {
  Servo& s = servos_[i];
  const std::int32_t units = s.cable.goalCurrent(s.description.cable.tension_max);
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
  readings_[i].measured = s.cable.displacement(position);
  return true;
}

void ServoChain::makeReadGroups() {
  groups_.clear();
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const std::uint16_t address = servos_[i].model->indirect_data;
    auto group = std::find_if(groups_.begin(), groups_.end(), [&](const ReadGroup& g) { return g.address == address; });
    if (group == groups_.end()) group = groups_.insert(groups_.end(), ReadGroup{address, {}, {}, {}, {}});
    group->members.push_back(i);
    group->ids.push_back(ids_[i]);
  }
  for (ReadGroup& g : groups_) {
    g.answers.resize(g.ids.size());
    g.fresh = [this, &g](std::size_t k, const std::uint8_t* data) { return isFresh(servos_[g.members[k]], data); };
  }
}

void ServoChain::setZero(int i, double displacement) {
  const auto k = static_cast<std::size_t>(i);
  servos_[k].cable.setZero(servos_[k].counts, displacement);
  readings_[k].measured = displacement;
  readings_[k].zero_valid = true;
}

void ServoChain::restoreZero(int i, double counts) {
  Servo& s = servos_[static_cast<std::size_t>(i)];
  s.cable.restoreZero(counts);
  s.remembered = true;
}

bool ServoChain::writeSetPoints(const double* set_points, Time /*now*/) {
  for (std::size_t i = 0; i < servos_.size(); ++i) values_[i] = servos_[i].cable.counts(set_points[i]);
  return bus_.syncWrite(reg::kGoalPosition, ids_, values_) != BusStatus::kClosed;
}

bool ServoChain::relax(const std::vector<bool>& which, double share) {
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    Servo& s = servos_[i];
    const double most = s.description.cable.tension_max;
    if (share >= 1) s.relaxed_from = std::min(most, std::max(0., readings_[i].effort));
    values_[i] = s.cable.goalCurrent(which[i] ? std::max(share, 0.) * s.relaxed_from : most);
  }
  return bus_.syncWrite(reg::kGoalCurrent, ids_, values_) != BusStatus::kClosed;
}

// Sync writes have no answer, so it is said twice.
bool ServoChain::switchOff(const std::vector<bool>& which) {
  some_ids_.clear();
  some_values_.clear();
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (!which[i]) continue;
    some_ids_.push_back(ids_[i]);
    some_values_.push_back(0);
  }
  bus_.syncWrite(reg::kTorqueEnable, some_ids_, some_values_);
  return bus_.syncWrite(reg::kTorqueEnable, some_ids_, some_values_) != BusStatus::kClosed;
}

bool ServoChain::read(Time now) {
  for (ActuatorReading& r : readings_) r.valid = false;
  asked_ = now;
  bool open = true;
  for (ReadGroup& g : groups_) {
    open = bus_.syncRead(g.address, kBlockSize, g.ids, g.answers, g.fresh) != BusStatus::kClosed && open;
    for (std::size_t k = 0; k < g.members.size(); ++k)
      if (g.answers[k].status == BusStatus::kOk) take(g.members[k], g.answers[k]);
  }
  for (ActuatorReading& r : readings_) {
    r.missing = r.valid ? 0 : r.missing + 1;
    if (r.missing >= missing_limit_) r.fault |= kFaultSilent;
  }
  return open;
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
  ActuatorReading& r = readings_[i];
  const std::uint8_t* data = answer.data.data();
  const int error = field(data, reg::kHardwareError), counts = field(data, reg::kPresentPosition);
  if (field(data, reg::kTorqueEnable) == 0) r.fault |= kFaultOff;
  if (field(data, reg::kPresentVoltage) == 0) return;
  r.valid = true;
  r.fault |= static_cast<std::uint32_t>(error);
  if (field(data, reg::kBusWatchdog) == kTripped) r.fault |= kFaultWatchdog;
  r.current = s.cable.amperes(field(data, reg::kPresentCurrent));
  r.effort = s.cable.tension(field(data, reg::kPresentCurrent));
  r.voltage = field(data, reg::kPresentVoltage) * kVoltsPerUnit;
  r.temperature = field(data, reg::kPresentTemperature);
  const double elapsed = s.anchored ? seconds(asked_ - s.read_at) : 0;
  if (s.anchored && std::abs(counts - s.counts) > kJumpCounts + kJumpCountsPerSecond * elapsed) r.fault |= kFaultJumped;
  if (r.voltage < s.model->min_voltage || (error & kVoltageError) != 0) r.fault |= kFaultUndervolted;
  if ((r.fault & (kFaultJumped | kFaultUndervolted)) != 0) r.zero_valid = false;
  s.counts = counts;
  s.tick = field(data, reg::kRealtimeTick);
  s.read_at = asked_;
  s.anchored = true;
  r.measured = s.cable.displacement(counts);
}

std::string ServoChain::faultDetail(int i) const {
  const std::uint32_t error = readings_[static_cast<std::size_t>(i)].fault & 0xFF;
  if (error == 0) return "";
  char text[64];
  std::snprintf(text, sizeof text, "hardware error register 70 = 0x%02X", static_cast<unsigned>(error));
  return text;
}

}  // namespace sinew
