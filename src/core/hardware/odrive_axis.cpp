#include "sinew/hardware/odrive_axis.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kSpeedMargin = 1.5;    // of the axis' velocity limit over the driver's rate
constexpr double kFindTime = 1;         // s for the first heartbeat
constexpr double kBootTime = 5;         // s for an axis that says it is starting
constexpr double kAnswerTime = 0.5;     // s for what was asked, with repetitions, or for a state to change
constexpr double kRepeatTime = 0.05;    // s between repetitions, but no more than ...
constexpr double kFeedShare = 0.4;      // ... this of what the watchdog lets pass
constexpr double kHeartbeats = 4;       // so many missed ones are a pause
constexpr double kBeatMargin = 1.2;     // by which heartbeats may come more slowly than they should
constexpr double kSlack = 0.1;          // s by which an axis' watchdog may be late
constexpr double kJumpTurns = 0.25;     // a position may differ so much from the last one, ...
constexpr double kJumpMargin = 2;       // ... plus this times what the velocity limit allows
constexpr double kMaxTurns = 1e6;       // beyond, a float no longer tells a position
constexpr double kUnmistakable = 1.25;  // turns from 0, where a restarted encoder never counts from
constexpr std::uint32_t kInitializing = 1;

constexpr OdriveCommand kAuxiliaries[] = {OdriveCommand::kGetIq, OdriveCommand::kGetError,
                                          OdriveCommand::kGetIq, OdriveCommand::kGetBusVoltageCurrent,
                                          OdriveCommand::kGetIq, OdriveCommand::kGetTemperature};
constexpr int kAuxiliaryCount = 6;

std::uint32_t bitOf(OdriveCommand command) {
  return 1u << static_cast<unsigned>(command);
}

bool isFromDevice(OdriveCommand command) {
  constexpr OdriveCommand kMessages[] = {
      OdriveCommand::kGetVersion,     OdriveCommand::kHeartbeat,           OdriveCommand::kGetError,
      OdriveCommand::kTxSdo,          OdriveCommand::kGetEncoderEstimates, OdriveCommand::kGetIq,
      OdriveCommand::kGetTemperature, OdriveCommand::kGetBusVoltageCurrent};
  return std::find(std::begin(kMessages), std::end(kMessages), command) != std::end(kMessages);
}

// Firmware 0.5 says other things under these numbers.
bool isKnown(OdriveCommand command, OdriveFirmware firmware) {
  return firmware == OdriveFirmware::k06 ||
         (command != OdriveCommand::kGetError && command != OdriveCommand::kGetTemperature);
}

}  // namespace

OdriveAxis::OdriveAxis(const OdriveSettings& settings, const WinchDescription& cable, const ActuatorBounds& bounds,
                       const DeviceTiming& timing)
    : settings_(settings),
      bounds_(bounds),
      timing_(timing),
      tension_per_ampere_(cable.sign * cable.torque_constant / cable.spool_radius),
      turns_per_meter_(cable.sign * settings.gear_ratio / (kTwoPi * cable.spool_radius)),
      current_limit_(cable.tension_max * cable.spool_radius / cable.torque_constant),
      velocity_limit_(kSpeedMargin * bounds.rate_max * std::abs(turns_per_meter_)),
      readings_(1) {
  if (!(current_limit_ > 0) || !std::isfinite(current_limit_))
    throw ConfigError(bounds.name + ".tension_max", std::to_string(cable.tension_max),
                      "N above 0 that the motor's current can bound");
  if (cable.homing.method == HomingMethod::kDevice)
    throw ConfigError(bounds.name + ".homing.method", "device", "present or tension for an ODrive");
  problem_.reserve(256);
}

double OdriveAxis::toDisplacement(double turns) const {
  return (turns - zero_) / turns_per_meter_;
}

double OdriveAxis::toTurns(double displacement) const {
  return zero_ + displacement * turns_per_meter_;
}

// --- Set-up ---

void OdriveAxis::startSetUp(bool home_all) {
  home_all_ = home_all;
  on_ = relaxing_ = anchored_ = heard_ = located_ = fresh_ = version_known_ = false;
  spoken_ = false;
  known_turns_ = turns_;
  awaited_ = 0;
  seen_errors_ = 0;
  armed_writes_ = 0;
  sent_ = started_ = {};
  step_ = Step::kFind;
  problem_.clear();
  reading().fault = 0;
  reading().missing = 0;
}

SetUpProgress OdriveAxis::fail(const std::string& what) {
  problem_ = bounds_.name + " (ODrive node " + std::to_string(settings_.node) + ") " + what;
  return SetUpProgress::kFailed;
}

SetUpProgress OdriveAxis::enter(Step step, Time now) {
  step_ = step;
  started_ = now;
  sent_ = {};
  spoken_ = answered_ = false;
  return step == Step::kDone ? SetUpProgress::kDone : SetUpProgress::kBusy;
}

// Whether something is to be sent, for the first time or again.
bool OdriveAxis::isDue(Time now) {
  if (sent_ != Time{} && now - sent_ < duration(std::min(kRepeatTime, kFeedShare * timing_.watchdog))) return false;
  sent_ = now;
  return true;
}

bool OdriveAxis::isOver(double time, Time now) const {
  return now - started_ > duration(time);
}

SetUpProgress OdriveAxis::updateSetUp(Time now, CanSender& out) {
  if (started_ == Time{}) {  // what has come until now may be old
    started_ = now;
    heard_ = false;
  }
  switch (step_) {
    case Step::kFind:
      return find(now, out);
    case Step::kIdle:
      return goIdle(now, out);
    case Step::kProve:
      return proveWatchdog(now);
    case Step::kArm:
      return armWatchdog(now, out);
    case Step::kLocate:
      return locate(now, out);
    case Step::kEnable:
      return enable(now, out);
    case Step::kDone:
      break;
  }
  return SetUpProgress::kDone;
}

SetUpProgress OdriveAxis::find(Time now, CanSender& out) {
  const bool asks_version = settings_.firmware == OdriveFirmware::k06;
  if (asks_version && !version_known_ && isDue(now))
    out.send(makeOdriveRequest(settings_.node, OdriveCommand::kGetVersion));
  const bool booting = heard_ && asks_version && (error_ & kInitializing) != 0;
  if (heard_ && !booting && (version_known_ || !asks_version)) {
    if (asks_version && (version_.major != 0 || version_.minor < 6))
      return fail("has firmware " + std::to_string(version_.major) + "." + std::to_string(version_.minor) +
                  ", expected 0.6 or newer; see the key firmware");
    const bool certain = proven_ || settings_.watchdog.given;
    if (!armed() || error_ != 0 || !certain) return enter(Step::kIdle, now);
    return enter(settings_.watchdog.given ? Step::kArm : Step::kLocate, now);
  }
  if (!isOver(booting ? kBootTime : kFindTime + kHeartbeats * settings_.heartbeat, now)) return SetUpProgress::kBusy;
  if (!heard_) return fail("is not heard: check its node number, the bit rate and the wiring");
  if (booting) return fail("does not finish starting");
  return fail("does not tell its version: is its firmware older than 0.6? Then set firmware: \"0.5\"");
}

SetUpProgress OdriveAxis::goIdle(Time now, CanSender& out) {
  const bool asked = sent_ != Time{};
  if (asked && spoken_ && idle() && error_ == 0) {
    if (settings_.watchdog.given) return enter(Step::kArm, now);
    return enter(proven_ ? Step::kLocate : Step::kProve, now);
  }
  if (isOver(kAnswerTime + 2 * settings_.heartbeat, now)) {
    if (!idle()) return fail("does not go idle");
    return fail("keeps its error " + describeOdriveError(settings_.firmware, error_));
  }
  if (isDue(now)) {
    out.send(makeOdriveAxisState(settings_.node, OdriveState::kIdle));
    out.send(makeOdriveClearErrors(settings_.node));
    spoken_ = false;
  }
  return SetUpProgress::kBusy;
}

// Nothing is sent to the axis until it reports that its watchdog has acted.
SetUpProgress OdriveAxis::proveWatchdog(Time now) {
  const double limit = timing_.watchdog + 2 * settings_.heartbeat + kSlack;
  if ((error_ & odriveWatchdogError(settings_.firmware)) != 0 && spoken_) {
    proven_ = true;
    return enter(Step::kLocate, now);
  }
  if (!isOver(limit, now)) return SetUpProgress::kBusy;
  return fail("has no watchdog that acts within " + std::to_string(timing_.watchdog) +
              " s: with odrivetool set axis0.config.watchdog_timeout and enable_watchdog, and save; or give the key "
              "watchdog");
}

// Timeout first, then enable; each is written, read back and compared.
SetUpProgress OdriveAxis::armWatchdog(Time now, CanSender& out) {
  const auto timeout = static_cast<float>(timing_.watchdog);
  OdriveSdo wanted{settings_.watchdog.enable, 1, 1};
  if (armed_writes_ == 0) {
    wanted = {settings_.watchdog.timeout, sizeof timeout, 0};
    std::memcpy(&wanted.value, &timeout, sizeof timeout);
  }
  if (answered_ && answer_.endpoint == wanted.endpoint) {
    answered_ = false;
    if (answer_.value == wanted.value) {
      sent_ = {};
      return ++armed_writes_ == 2 ? enter(Step::kLocate, now) : SetUpProgress::kBusy;
    }
  }
  if (isOver(2 * kAnswerTime, now))
    return fail("does not take its watchdog's settings at endpoint " + std::to_string(wanted.endpoint) +
                ": is it of this firmware's flat_endpoints.json?");
  if (isDue(now)) {
    out.send(makeOdriveSdoWrite(settings_.node, wanted));
    out.send(makeOdriveSdoRead(settings_.node, wanted.endpoint));
  }
  return SetUpProgress::kBusy;
}

void OdriveAxis::sendLimits(double current, CanSender& out) {
  out.send(makeOdriveLimits(settings_.node, static_cast<float>(velocity_limit_), static_cast<float>(current)));
}

// The position now becomes the goal before limits are raised and the loop is closed: nothing moves.
SetUpProgress OdriveAxis::locate(Time now, CanSender& out) {
  const bool asked = sent_ != Time{};
  if (asked && located_) {
    checkZero();
    goal_ = static_cast<float>(turns_);
    configure(out);
    return enter(Step::kEnable, now);
  }
  if (isOver(kAnswerTime, now)) return fail("does not tell its position");
  located_ = false;
  awaited_ = bitOf(OdriveCommand::kGetEncoderEstimates);
  sent_ = now;
  out.send(makeOdriveRequest(settings_.node, OdriveCommand::kGetEncoderEstimates));
  return SetUpProgress::kBusy;
}

void OdriveAxis::configure(CanSender& out) {
  out.send(makeOdriveInputPos(settings_.node, goal_));
  if (!armed()) out.send(makeOdriveClearErrors(settings_.node));
  out.send(makeOdrivePositionMode(settings_.node, settings_.input));
  if (settings_.input == OdriveInput::kTrapezoidal) {
    const double acceleration = settings_.acceleration * std::abs(turns_per_meter_);
    out.send(makeOdriveTrajVelLimit(settings_.node, static_cast<float>(velocity_limit_)));
    out.send(makeOdriveTrajAccelLimits(settings_.node, static_cast<float>(acceleration)));
  }
  sendLimits(current_limit_, out);
}

SetUpProgress OdriveAxis::enable(Time now, CanSender& out) {
  const bool asked = sent_ != Time{};
  if (asked && spoken_ && armed() && error_ == 0) {
    on_ = true;
    seen_errors_ = 0;
    reading().fault = 0;
    return enter(Step::kDone, now);
  }
  if (isOver(kAnswerTime + 3 * settings_.heartbeat, now)) {
    if (error_ != 0) return fail("does not close its loop: " + describeOdriveError(settings_.firmware, error_));
    return fail("does not close its loop: is it calibrated?");
  }
  out.send(makeOdriveInputPos(settings_.node, goal_));
  if (!asked || (!armed() && isDue(now))) {
    sent_ = now;
    spoken_ = false;
    out.send(makeOdriveAxisState(settings_.node, OdriveState::kClosedLoop));
  }
  return SetUpProgress::kBusy;
}

void OdriveAxis::checkZero() {
  ActuatorReading& r = reading();
  const bool unmistakable = std::abs(known_turns_) > kUnmistakable && std::abs(turns_ - known_turns_) <= kJumpTurns;
  const bool paused = silence_ > kHeartbeats * settings_.heartbeat;
  if (home_all_ || (paused && !armed() && !unmistakable)) r.zero_valid = false;
  if (!r.zero_valid) zero_ = turns_;
  silence_ = 0;
  r.measured = toDisplacement(turns_);
}

// --- The cycle ---

void OdriveAxis::writeSetPoints(const double* set_points, Time, CanSender& out) {
  goal_ = static_cast<float>(toTurns(set_points[0]));
  out.send(makeOdriveInputPos(settings_.node, goal_));
}

void OdriveAxis::request(Time, CanSender& out) {
  awaited_ = 0;
  if (settings_.cyclic) {
    if (!fresh_) awaited_ = bitOf(OdriveCommand::kGetEncoderEstimates);
    return;
  }
  do {
    auxiliary_ = (auxiliary_ + 1) % kAuxiliaryCount;
  } while (!isKnown(kAuxiliaries[auxiliary_], settings_.firmware));
  for (const OdriveCommand c : {OdriveCommand::kGetEncoderEstimates, kAuxiliaries[auxiliary_]}) {
    awaited_ |= bitOf(c);
    out.send(makeOdriveRequest(settings_.node, c));
  }
}

bool OdriveAxis::take(const CanFrame& frame, Time now) {
  const OdriveCommand command = odriveCommand(frame);
  if (frame.extended || frame.remote || odriveNode(frame) != settings_.node || !isFromDevice(command)) return false;
  if (!isAwaited(command))
    ++counters_.stale;
  else if (!takeMessage(command, frame, now))
    ++counters_.corrupted;
  else
    awaited_ &= ~bitOf(command);
  return true;
}

// What is asked for counts once; what comes by itself, and answers of set-up, always.
bool OdriveAxis::isAwaited(OdriveCommand command) const {
  return settings_.cyclic || (awaited_ & bitOf(command)) != 0 || command == OdriveCommand::kHeartbeat ||
         command == OdriveCommand::kGetVersion || command == OdriveCommand::kTxSdo;
}

// False when the frame cannot be that message.
bool OdriveAxis::takeMessage(OdriveCommand command, const CanFrame& frame, Time now) {
  OdriveHeartbeat heartbeat;
  OdriveError error;
  OdrivePair pair;
  switch (command) {
    case OdriveCommand::kHeartbeat:
      if (!decodeOdrive(frame, heartbeat)) return false;
      takeHeartbeat(heartbeat, now);
      return true;
    case OdriveCommand::kGetVersion:
      version_known_ = decodeOdrive(frame, version_);
      return version_known_;
    case OdriveCommand::kTxSdo:
      answered_ = decodeOdrive(frame, answer_);
      return answered_;
    case OdriveCommand::kGetError:
      if (!decodeOdrive(frame, error)) return false;
      if (isKnown(command, settings_.firmware)) takeError(error.active);
      return true;
    default:
      if (!decodeOdrive(frame, pair)) return false;
      if (command == OdriveCommand::kGetEncoderEstimates && !(std::abs(pair.first) < kMaxTurns)) return false;
      takePair(command, pair, now);
      return true;
  }
}

void OdriveAxis::takePair(OdriveCommand command, const OdrivePair& pair, Time now) {
  ActuatorReading& r = reading();
  const double first = static_cast<double>(pair.first), second = static_cast<double>(pair.second);
  if (command == OdriveCommand::kGetEncoderEstimates) {
    takePosition(first, now);
  } else if (command == OdriveCommand::kGetIq) {
    r.effort = tension_per_ampere_ * second;
    r.current = std::copysign(second, tension_per_ampere_ * second);
  } else if (command == OdriveCommand::kGetTemperature && isKnown(command, settings_.firmware)) {
    r.temperature = std::max(first, second);
  } else if (command == OdriveCommand::kGetBusVoltageCurrent) {
    r.voltage = first;
    if (on_ && r.voltage < settings_.voltage_min) r.fault |= kFaultUndervolted;
  }
}

void OdriveAxis::takeHeartbeat(const OdriveHeartbeat& heartbeat, Time now) {
  if (beat_at_ != Time{})
    silence_ = std::max(0., silence_ + seconds(now - beat_at_) - kBeatMargin * settings_.heartbeat);
  beat_at_ = now;
  heard_ = spoken_ = true;
  state_ = heartbeat.state;
  error_ = heartbeat.error;
  if (!on_) return;
  takeError(heartbeat.error);
  if (armed()) return;
  reading().fault |= kFaultOff;
  const bool restarted = error_ == 0 || (settings_.firmware == OdriveFirmware::k06 && (error_ & kInitializing) != 0);
  if (restarted) reading().zero_valid = false;
}

void OdriveAxis::takeError(std::uint32_t error) {
  seen_errors_ |= error;
  if (on_) reading().fault |= calcOdriveFaults(settings_.firmware, error);
}

void OdriveAxis::takePosition(double turns, Time now) {
  const double allowed = kJumpTurns + kJumpMargin * velocity_limit_ * seconds(now - turns_at_);
  if (anchored_ && on_ && std::abs(turns - turns_) > allowed) reading().fault |= kFaultJumped;
  turns_ = turns;
  turns_at_ = now;
  anchored_ = located_ = fresh_ = true;
  reading().measured = toDisplacement(turns);
}

void OdriveAxis::endCycle(Time now) {
  ActuatorReading& r = reading();
  for (Frames left = awaited_; left != 0; left &= left - 1) ++counters_.missing;
  awaited_ = 0;
  r.valid = fresh_;
  fresh_ = false;
  r.missing = r.valid ? 0 : r.missing + 1;
  const bool quiet = now - beat_at_ > duration(kHeartbeats * settings_.heartbeat);
  if (r.missing >= timing_.missing_limit || quiet) r.fault |= kFaultSilent;
  if ((r.fault & (kFaultJumped | kFaultUndervolted)) != 0) r.zero_valid = false;
}

void OdriveAxis::relax(const bool* which, double share, CanSender& out) {
  if (!which[0]) return;
  if (!relaxing_) relaxed_from_ = std::min(std::abs(reading().current), current_limit_);
  relaxing_ = true;
  sendLimits(std::min(std::max(share, 0.), 1.) * relaxed_from_, out);
}

void OdriveAxis::switchOff(const bool* which, CanSender& out) {
  if (!which[0]) return;
  on_ = false;
  out.send(makeOdriveAxisState(settings_.node, OdriveState::kIdle));
}

void OdriveAxis::setZero(int, double displacement) {
  zero_ = turns_ - displacement * turns_per_meter_;
  reading().measured = displacement;
  reading().zero_valid = true;
}

std::string OdriveAxis::faultDetail(int) const {
  return seen_errors_ == 0 ? "" : "axis error " + describeOdriveError(settings_.firmware, seen_errors_);
}

}  // namespace sinew
