#include "sinew/hardware/canopen_drive.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr int kTries = 4;                    // of an SDO on a bad line
const Duration kSdoTimeout = duration(0.1);  // of one answer
constexpr int kHeartbeats = 4;               // of the driver within the drive's watchdog
constexpr double kTurn = 6.283185307179586;  // rad
constexpr double kJump = kTurn / 4;          // rad of the spool from one reading to the next, plus ...
constexpr double kJumpSpeed = 2 * kTurn;     // ... rad/s since
constexpr std::size_t kPositionSize = 6;     // bytes of the PDO with statusword and position

void check(const CanopenSettings& s, const WinchDescription& cable, const ActuatorBounds& bounds) {
  if (cable.homing.method == HomingMethod::kDevice && s.homing.method == 0)
    throw ConfigError(bounds.name + ".drive_homing", "nothing", "the drive's homing, which homing.method asks for");
  const CanopenUnits units(s, cable);
  if (!units.canTell(bounds.min) || !units.canTell(bounds.max))
    throw ConfigError(bounds.name, "a range of displacement beyond the drive's 32 bits of position",
                      "fewer counts_per_turn, a smaller gear or range");
}

}  // namespace

CanopenDrive::CanopenDrive(const CanopenSettings& settings, const WinchDescription& cable, const ActuatorBounds& bounds,
                           const DeviceTiming& timing)
    : settings_((check(settings, cable, bounds), settings)),
      name_(bounds.name),
      tension_max_(cable.tension_max),
      min_(bounds.min),
      max_(bounds.max),
      watchdog_(duration(timing.watchdog)),
      heartbeat_period_(watchdog_ / kHeartbeats),
      missing_limit_(timing.missing_limit),
      units_(settings, cable),
      sdo_(settings.node, kSdoTimeout, kTries),
      set_up_(settings, cable, bounds, timing),
      effort_(CanopenSetUp::effortObjects(settings.effort)),
      readings_(1) {}

// --- Set-up ---

void CanopenDrive::startSetUp(bool home_all) {
  life_ = Life::kSetUp;
  problem_.clear();
  if (home_all) reading().zero_valid = false;
  reading().fault = 0;
  reading().missing = 0;
  reading().valid = false;
  nmt_ = canopen::NmtState::kBootUp;
  emergency_ = {};
  stopped_ = off_ = relaxing_ = limited_ = asked_code_ = anchored_ = heartbeat_sent_ = false;
  asked_ = position_seen_ = effort_seen_ = false;
  sdo_.reset();
  set_up_.start(!reading().zero_valid);
}

SetUpProgress CanopenDrive::updateSetUp(Time now, CanSender& out) {
  if (life_ != Life::kSetUp) return life_ == Life::kRunning ? SetUpProgress::kDone : SetUpProgress::kFailed;
  sendHeartbeat(now, out);
  switch (set_up_.update(now, out, sdo_, nmt_, units_)) {
    case SetUpProgress::kBusy:
      return SetUpProgress::kBusy;
    case SetUpProgress::kFailed:
      return failSetUp(set_up_.problem(), out);
    default:
      return finishSetUp(now) ? SetUpProgress::kDone
                              : failSetUp("cannot tell its range in 32 bits; home it nearer to its zero", out);
  }
}

SetUpProgress CanopenDrive::failSetUp(const std::string& what, CanSender& out) {
  life_ = Life::kIdle;
  out.send(canopen::makeNmt(canopen::NmtCommand::kPreOperational, settings_.node));
  const std::uint8_t stop[] = {cia402::kQuickStop, 0};  // in case it was homing
  out.send(canopen::makeSdoDownload(settings_.node, {cia402::kControlword, 0}, stop, sizeof stop));
  const std::string detail = faultDetail(0);
  problem_ =
      name_ + " (node " + std::to_string(settings_.node) + ") " + what + (detail.empty() ? "" : "; it says: " + detail);
  return SetUpProgress::kFailed;
}

bool CanopenDrive::finishSetUp(Time now) {
  ActuatorReading& r = reading();
  const bool lost = (restarted_ || !set_up_.wasConfigured()) && !settings_.absolute_encoder;
  if (lost) r.zero_valid = false;
  restarted_ = false;
  counts_ = target_ = set_up_.position();
  if (!r.zero_valid) units_.setZero(counts_, 0);
  if (set_up_.homed()) r.zero_valid = true;
  r.measured = units_.displacement(counts_);
  state_ = cia402::State::kOperationEnabled;
  anchored_ = true;
  read_at_ = now;
  life_ = Life::kRunning;
  return units_.canTell(min_) && units_.canTell(max_);
}

void CanopenDrive::setZero(int, double displacement) {
  units_.setZero(counts_, displacement);
  reading().measured = displacement;
  reading().zero_valid = true;
}

// --- The cycle ---

void CanopenDrive::sendHeartbeat(Time now, CanSender& out) {
  if (heartbeat_sent_ && now - heartbeat_at_ < heartbeat_period_) return;
  if (!out.send(canopen::makeHeartbeat(settings_.driver_node, canopen::NmtState::kOperational))) return;
  heartbeat_at_ = now;
  heartbeat_sent_ = true;
}

void CanopenDrive::sendControl(std::uint16_t controlword, std::int32_t target, CanSender& out) {
  CanFrame frame;
  frame.id = canopen::kRpdoId + settings_.node;
  frame.size = 6;
  canopen::storeNumber(controlword, 2, &frame.data[0]);
  canopen::storeNumber(static_cast<std::uint32_t>(target), 4, &frame.data[2]);
  out.send(frame);
}

void CanopenDrive::writeSetPoints(const double* set_points, Time now, CanSender& out) {
  if (life_ != Life::kRunning) return;
  asked_ = true;
  asked_at_ = now;
  if (now - heartbeat_at_ > watchdog_ && !off_) raise(kFaultWatchdog);
  sendHeartbeat(now, out);
  updateErrorCode(now, out);
  if (std::isfinite(set_points[0])) target_ = units_.counts(set_points[0]);
  sendControl(off_ ? cia402::kDisableVoltage : stopped_ ? cia402::kQuickStop : cia402::kEnableOperation, target_, out);
}

// The emergency of a fault may have been lost.
void CanopenDrive::updateErrorCode(Time now, CanSender& out) {
  if (state_ != cia402::State::kFault || emergency_.code != 0) return;
  if (!asked_code_) sdo_.startUpload({cia402::kErrorCode, 0});
  asked_code_ = true;
  sdo_.update(now, out);
  if (sdo_.status() != CanopenSdo::Status::kDone) return;
  emergency_.code = static_cast<std::uint16_t>(sdo_.value());
  raise(cia402::calcFault(emergency_.code));
}

void CanopenDrive::endCycle(Time) {
  if (life_ != Life::kRunning) return;
  ActuatorReading& r = reading();
  r.valid = complete();
  r.missing = r.valid ? 0 : r.missing + 1;
  if (!r.valid) ++counters_.missing;
  if (r.missing >= missing_limit_) r.fault |= kFaultSilent;
  asked_ = position_seen_ = effort_seen_ = false;
}

void CanopenDrive::relax(const bool* which, double share, CanSender& out) {
  out.send(canopen::makeHeartbeat(settings_.driver_node, canopen::NmtState::kOperational));
  if (!which[0] || life_ != Life::kRunning) return;
  if (!relaxing_) relaxed_from_ = std::min(tension_max_, std::max(0., reading().effort));
  relaxing_ = true;
  const double limit = units_.effortLimit(std::min(1., std::max(0., share)) * relaxed_from_);
  std::uint8_t data[canopen::kExpeditedSize];
  canopen::storeNumber(static_cast<std::uint32_t>(limit), effort_.limit_size, data);
  out.send(canopen::makeSdoDownload(settings_.node, effort_.limit, data, effort_.limit_size));
}

// Said twice: the PDO's controlword waits for the next SYNC, the SDO's acts at once.
void CanopenDrive::switchOff(const bool* which, CanSender& out) {
  if (!which[0]) return;
  off_ = true;
  sendControl(cia402::kDisableVoltage, target_, out);
  const std::uint8_t data[2] = {cia402::kDisableVoltage, 0};
  out.send(canopen::makeSdoDownload(settings_.node, {cia402::kControlword, 0}, data, sizeof data));
}

// --- What comes from the drive ---

bool CanopenDrive::take(const CanFrame& frame, Time now) {
  if (frame.extended || frame.remote) return false;
  if (takeSdo(frame)) return true;
  if (frame.id == canopen::kHeartbeatId + settings_.node) {
    canopen::NmtState state{};
    if (canopen::readHeartbeat(frame, settings_.node, state))
      takeHeartbeat(state);
    else
      ++counters_.corrupted;
  } else if (frame.id == canopen::kEmergencyId + settings_.node) {
    canopen::Emergency emergency;
    if (canopen::readEmergency(frame, settings_.node, emergency))
      takeEmergency(emergency);
    else
      ++counters_.corrupted;
  } else if (frame.id == canopen::kTpdoId + settings_.node) {
    if (isAnswer(frame, kPositionSize)) takePosition(frame, now);
  } else if (frame.id == canopen::kTpdoId + canopen::kPdoIdStep + settings_.node) {
    if (isAnswer(frame, effort_.actual_size)) takeEffort(frame);
  } else {
    return false;
  }
  return true;
}

bool CanopenDrive::takeSdo(const CanFrame& frame) {
  const std::uint64_t malformed = sdo_.malformed(), stale = sdo_.stale();
  const bool taken = sdo_.take(frame);
  counters_.corrupted += sdo_.malformed() - malformed;
  counters_.stale += sdo_.stale() - stale;
  return taken;
}

bool CanopenDrive::isAnswer(const CanFrame& frame, std::size_t size) {
  if (frame.size != size)
    ++counters_.corrupted;
  else if (!asked_)
    ++counters_.stale;
  return life_ == Life::kRunning && frame.size == size && asked_;
}

// A drive that has stopped by itself is not enabled again: it would move.
void CanopenDrive::raise(std::uint32_t fault) {
  reading().fault |= fault;
  if ((fault & (kFaultWatchdog | kFaultOff)) != 0) stopped_ = true;
  if ((fault & (kFaultJumped | kFaultUndervolted)) != 0) loseZero();
}

void CanopenDrive::loseZero() {
  if (!settings_.absolute_encoder) reading().zero_valid = false;
}

void CanopenDrive::takeHeartbeat(canopen::NmtState state) {
  nmt_ = state;
  if (state == canopen::NmtState::kBootUp) {
    restarted_ = true;
    loseZero();
  }
  if (life_ != Life::kRunning || state == canopen::NmtState::kOperational) return;
  stopped_ = true;
  if (!off_) raise(kFaultOff);
}

void CanopenDrive::takeEmergency(const canopen::Emergency& emergency) {
  if (emergency.code == 0) return;
  ++counters_.device_error;
  emergency_ = emergency;
  const std::uint32_t fault = cia402::calcFault(emergency.code);
  if (life_ == Life::kRunning)
    raise(fault);
  else if ((fault & kFaultUndervolted) != 0)
    loseZero();
}

void CanopenDrive::takePosition(const CanFrame& frame, Time now) {
  const std::int32_t counts = canopen::loadSigned(&frame.data[2], 4);
  const double moved = std::abs(static_cast<double>(counts) - counts_) / units_.countsPerRadian();
  if (anchored_ && moved > kJump + kJumpSpeed * seconds(asked_at_ - read_at_)) raise(kFaultJumped);
  counts_ = counts;
  read_at_ = asked_at_;
  position_seen_ = true;
  reading().measured = units_.displacement(counts);
  takeStatus(static_cast<std::uint16_t>(canopen::loadNumber(&frame.data[0], 2)), now);
}

void CanopenDrive::takeStatus(std::uint16_t statusword, Time now) {
  state_ = cia402::calcState(statusword);
  if (off_) return;
  switch (state_) {
    case cia402::State::kOperationEnabled:
      watchLimits(statusword, now);
      return;
    case cia402::State::kQuickStopActive:
      if (!stopped_) raise(kFaultWatchdog);
      break;
    case cia402::State::kFault:
    case cia402::State::kFaultReaction:
      if (emergency_.code == 0) raise(kFaultDevice);
      break;
    default:
      raise(kFaultOff);
  }
  stopped_ = true;
}

void CanopenDrive::watchLimits(std::uint16_t statusword, Time now) {
  if ((statusword & cia402::kFollowingError) != 0) raise(kFaultFollowing);
  const bool limited = (statusword & cia402::kInternalLimit) != 0;
  if (limited && !limited_) limited_since_ = now;
  limited_ = limited;
  if (limited && seconds(now - limited_since_) > settings_.limit_time) raise(kFaultOverload);
}

void CanopenDrive::takeEffort(const CanFrame& frame) {
  const std::int32_t effort = canopen::loadSigned(frame.data.data(), effort_.actual_size);
  reading().effort = units_.tension(effort);
  reading().current = units_.amperes(effort);
  effort_seen_ = true;
}

std::string CanopenDrive::faultDetail(int) const {
  std::string detail;
  if (emergency_.code != 0) {
    char text[96];
    std::snprintf(text, sizeof text, "error code 0x%04X (%s), error register 0x%02X", emergency_.code,
                  canopen::describeEmergency(emergency_.code), emergency_.error_register);
    detail = text;
  }
  const bool told = life_ == Life::kRunning && state_ != cia402::State::kOperationEnabled;
  if (told) detail += std::string(detail.empty() ? "" : ", ") + "state " + cia402::describe(state_);
  return detail;
}

}  // namespace sinew
