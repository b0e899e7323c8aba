#include "sinew/hardware/canopen_set_up.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

using canopen::calcMapping;
using canopen::NmtCommand;
using canopen::NmtState;
using canopen::ObjectAddress;

// Objects of CiA 301.
constexpr std::uint16_t kDeviceType = 0x1000;
constexpr std::uint16_t kConsumerHeartbeat = 0x1016;
constexpr std::uint16_t kProducerHeartbeat = 0x1017;
constexpr std::uint16_t kIdentity = 0x1018;
constexpr std::uint16_t kErrorBehaviour = 0x1029;
constexpr std::uint16_t kRpdo = 0x1400, kTpdo = 0x1800;  // parameters of the first PDO; mappings are 0x200 above
constexpr std::uint16_t kMappingOffset = 0x200;

constexpr std::uint32_t kPdoOff = 0x80000000;       // in a PDO's identifier
constexpr std::uint32_t kPdoNoRemote = 0x40000000;  // in a TPDO's identifier
constexpr std::uint32_t kEverySync = 1;             // transmission type
constexpr std::uint32_t kStayInState = 1;           // error behaviour

constexpr double kSpeedMargin = 1.2;  // of the drive's own limit over the driver's rate
const Duration kNmtTime = duration(3);
const Duration kModeTime = duration(1);
const Duration kSwitchOnTime = duration(3);
const Duration kQuickStopTime = duration(1);  // until a drive that does not leave quick stop is switched off

std::string describe(ObjectAddress object) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%04X:%02X", object.index, object.subindex);
  return text;
}

std::string describeHex(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%X", value);
  return text;
}

NmtState stateAfter(NmtCommand command) {
  return command == NmtCommand::kStart ? NmtState::kOperational : NmtState::kPreOperational;
}

}  // namespace

const CanopenSetUp::EffortObjects& CanopenSetUp::effortObjects(CanopenEffort effort) {
  static constexpr EffortObjects kObjects[] = {
      {{cia402::kMaxTorque, 0}, {cia402::kTorque, 0}, {cia402::kRatedTorque, 0}, 2, 2},
      {{cia402::kMaxCurrent, 0}, {cia402::kCurrent, 0}, {cia402::kRatedCurrent, 0}, 2, 2},
      {{0x3001, 2}, {0x30D1, 2}, {0x3001, 1}, 4, 4}};
  return kObjects[static_cast<std::size_t>(effort)];
}

CanopenSetUp::CanopenSetUp(const CanopenSettings& s, const WinchDescription& cable, const ActuatorBounds& bounds,
                           const DeviceTiming& timing)
    : node_(s.node),
      effort_(effortObjects(s.effort)),
      tension_max_(cable.tension_max),
      absolute_encoder_(s.absolute_encoder),
      homing_timeout_(duration(s.homing.timeout)),
      answer_time_(duration(3 * s.heartbeat)) {
  const CanopenUnits units(s, cable);
  addIdentity(s);
  addSupervision(s, timing);
  for (const CanopenObject& o : s.objects) addWrite(o.index, o.subindex, o.size, o.value);
  addPdos(s);
  addLimits(s, bounds, units);
  addPeriod(timing.period, bounds.name);
  add(Action::kReachNmt, {}, 0, static_cast<std::uint32_t>(NmtCommand::kStart));
  add(Action::kHoldPresent);
  addMode(cia402::kCyclicPosition);
  add(Action::kSwitchOn);
  homing_begin_ = steps_.size();
  if (cable.homing.method == HomingMethod::kDevice) addHoming(s, units);
  homing_end_ = steps_.size();
  add(Action::kReadPosition, {cia402::kPosition, 0}, 4);
}

void CanopenSetUp::add(Action action, ObjectAddress object, std::size_t size, std::uint32_t value, std::uint32_t mask) {
  steps_.push_back({action, object, size, value, mask, Need::kMust});
}

void CanopenSetUp::addWrite(std::uint16_t index, std::uint8_t subindex, std::size_t size, std::uint32_t value,
                            Need need) {
  steps_.push_back({Action::kWrite, {index, subindex}, size, value, 0, need});
}

void CanopenSetUp::addIdentity(const CanopenSettings& s) {
  add(Action::kTellNmt, {}, 0, static_cast<std::uint32_t>(NmtCommand::kPreOperational));
  add(Action::kCheck, {kDeviceType, 0}, 4, cia402::kProfile, 0xFFFF);
  if (s.vendor != 0) add(Action::kCheck, {kIdentity, 1}, 4, s.vendor);
  if (s.product != 0) add(Action::kCheck, {kIdentity, 2}, 4, s.product);
}

// The drive stops by itself when the driver's heartbeat is missing, and stays where its PDOs tell that it has.
void CanopenSetUp::addSupervision(const CanopenSettings& s, const DeviceTiming& timing) {
  const double watchdog = std::ceil(1e3 * timing.watchdog - 1e-6), heartbeat = std::ceil(1e3 * s.heartbeat - 1e-6);
  if (watchdog < 2 || watchdog > 0xFFFF)
    throw ConfigError("the watchdog of a CANopen drive", std::to_string(timing.watchdog) + " s", "0.002 to 65.535 s");
  const std::uint32_t consumer = static_cast<std::uint32_t>(s.driver_node) << 16 | static_cast<std::uint32_t>(watchdog);
  add(Action::kFindTrace, {kConsumerHeartbeat, 1}, 4, consumer);
  addWrite(kProducerHeartbeat, 0, 2, static_cast<std::uint32_t>(heartbeat));
  add(Action::kReachNmt, {}, 0, static_cast<std::uint32_t>(NmtCommand::kPreOperational));
  addWrite(kErrorBehaviour, 1, 1, kStayInState, Need::kMay);
  addWrite(cia402::kAbortConnection, 0, 2, cia402::kAbortByQuickStop);
  addWrite(cia402::kQuickStopOption, 0, 2,
           s.hold_on_silence ? cia402::kQuickStopAndStay : cia402::kQuickStopAndDisable);
  addWrite(kConsumerHeartbeat, 1, 4, consumer);
}

// A PDO is switched off while its mapping is emptied, filled and counted.
void CanopenSetUp::addPdo(std::uint16_t parameters, std::uint32_t id, std::initializer_list<std::uint32_t> mappings) {
  const auto mapping = static_cast<std::uint16_t>(parameters + kMappingOffset);
  addWrite(parameters, 1, 4, id | kPdoOff);
  addWrite(mapping, 0, 1, 0);
  std::uint8_t count = 0;
  for (const std::uint32_t entry : mappings) addWrite(mapping, ++count, 4, entry);
  addWrite(mapping, 0, 1, count);
  addWrite(parameters, 2, 1, kEverySync);
  addWrite(parameters, 1, 4, id);
}

void CanopenSetUp::addPdos(const CanopenSettings& s) {
  addPdo(kRpdo, canopen::kRpdoId + s.node,
         {calcMapping({cia402::kControlword, 0}, 2), calcMapping({cia402::kTarget, 0}, 4)});
  const std::uint32_t first = (canopen::kTpdoId + s.node) | kPdoNoRemote;
  addPdo(kTpdo, first, {calcMapping({cia402::kStatusword, 0}, 2), calcMapping({cia402::kPosition, 0}, 4)});
  addPdo(kTpdo + 1, first + canopen::kPdoIdStep, {calcMapping(effort_.actual, effort_.actual_size)});
  // Whatever the others are set to would only fill the bus.
  for (std::uint16_t n = 2; n < 4; ++n)
    addWrite(static_cast<std::uint16_t>(kTpdo + n), 1, 4, (first + n * canopen::kPdoIdStep) | kPdoOff, Need::kMay);
}

void CanopenSetUp::addLimits(const CanopenSettings& s, const ActuatorBounds& bounds, const CanopenUnits& units) {
  const double omega = kSpeedMargin * bounds.rate_max / units.radius();
  addWrite(cia402::kFollowingWindow, 0, 4, units.window(s.following_window), Need::kMay);
  addWrite(cia402::kMaxProfileVelocity, 0, 4, units.speed(omega), Need::kMay);
  addWrite(cia402::kMaxMotorSpeed, 0, 4, units.rpm(omega), Need::kMay);
  addEffortLimit();
}

void CanopenSetUp::addEffortLimit() {
  add(Action::kReadRating, effort_.rating, 4);
  limit_ = steps_.size();
  addWrite(effort_.limit.index, effort_.limit.subindex, effort_.limit_size, 0);
  add(Action::kCheck, effort_.limit, effort_.limit_size);
}

// Object 60C2: value (8 bits) and power of ten of the seconds between two targets.
void CanopenSetUp::addPeriod(double period, const std::string& name) {
  for (int power = -3; power >= -6; --power) {
    const double value = std::round(period * std::pow(10., -power));
    if (std::abs(value * std::pow(10., power) - period) > 1e-9 || value < 1 || value > 255) continue;
    const auto unit = static_cast<std::uint8_t>(power);
    addWrite(cia402::kInterpolationPeriod, 2, 1, unit, Need::kMay);
    addWrite(cia402::kInterpolationPeriod, 1, 1, static_cast<std::uint32_t>(value));
    add(Action::kCheck, {cia402::kInterpolationPeriod, 1}, 1, static_cast<std::uint32_t>(value));
    add(Action::kCheck, {cia402::kInterpolationPeriod, 2}, 1, unit);
    return;
  }
  throw ConfigError("the cycle's period for the drive " + name, std::to_string(period) + " s",
                    "1 to 255 times a power of ten from 1e-6 to 1e-3 s, e.g. 0.01");
}

void CanopenSetUp::addMode(std::uint8_t mode) {
  addWrite(cia402::kMode, 0, 1, mode);
  add(Action::kAwaitMode, {cia402::kModeDisplay, 0}, 1, mode);
}

void CanopenSetUp::addHoming(const CanopenSettings& s, const CanopenUnits& units) {
  addWrite(cia402::kHomingMethod, 0, 1, static_cast<std::uint8_t>(s.homing.method));
  addWrite(cia402::kHomingSpeeds, 1, 4, units.speed(s.homing.search_speed));
  addWrite(cia402::kHomingSpeeds, 2, 4, units.speed(s.homing.zero_speed));
  addWrite(cia402::kHomingAcceleration, 0, 4, units.speed(s.homing.acceleration));
  addMode(cia402::kHoming);
  add(Action::kStartHoming, {cia402::kControlword, 0}, 2, cia402::kStartHoming);
  add(Action::kAwaitHoming, {cia402::kStatusword, 0}, 2);
  addWrite(cia402::kControlword, 0, 2, cia402::kEnableOperation);
  add(Action::kHoldPresent);
  addMode(cia402::kCyclicPosition);
}

void CanopenSetUp::start(bool home) {
  home_ = home;
  at_ = 0;
  asked_ = timed_ = homed_ = was_configured_ = at_target_ = false;
  turn_ = Turn::kStatus;
  controlword_ = cia402::kDisableVoltage;
  problem_.clear();
}

SetUpProgress CanopenSetUp::update(Time now, CanSender& out, CanopenSdo& sdo, NmtState nmt, CanopenUnits& units) {
  now_ = now;
  while (at_ < steps_.size()) {
    if (!timed_) began_ = now;
    timed_ = true;
    if (!asked_) {
      ask(steps_[at_], out, sdo);
      asked_ = true;
      asked_at_ = now;
    }
    const Outcome outcome = answer(steps_[at_], nmt, sdo, units);
    if (outcome == Outcome::kWait) break;
    if (outcome == Outcome::kFailed) return SetUpProgress::kFailed;
    asked_ = false;
    if (outcome == Outcome::kNext) next();
    if (outcome == Outcome::kAgain && steps_[at_].action == Action::kReachNmt) break;
  }
  sdo.update(now, out);
  if (at_ < steps_.size()) return SetUpProgress::kBusy;
  set_up_before_ = true;
  return SetUpProgress::kDone;
}

void CanopenSetUp::next() {
  timed_ = at_target_ = false;
  ++at_;
  if (at_ == homing_begin_ && !home_) at_ = homing_end_;
  if (at_ == steps_.size()) return;
  turn_ = steps_[at_].action == Action::kHoldPresent ? Turn::kPosition : Turn::kStatus;
}

void CanopenSetUp::ask(const Step& step, CanSender& out, CanopenSdo& sdo) {
  switch (step.action) {
    case Action::kTellNmt:
    case Action::kReachNmt:
      out.send(canopen::makeNmt(static_cast<NmtCommand>(step.value), node_));
      break;
    case Action::kWrite:
    case Action::kStartHoming:
      sdo.startDownload(step.object, step.value, step.size);
      break;
    case Action::kSwitchOn:
    case Action::kHoldPresent:
      askTurn(sdo);
      break;
    default:
      sdo.startUpload(step.object);
  }
}

void CanopenSetUp::askTurn(CanopenSdo& sdo) {
  switch (turn_) {
    case Turn::kStatus:
      sdo.startUpload({cia402::kStatusword, 0});
      break;
    case Turn::kPosition:
      sdo.startUpload({cia402::kPosition, 0});
      break;
    case Turn::kTarget:
      sdo.startDownload({cia402::kTarget, 0}, static_cast<std::uint32_t>(position_), 4);
      break;
    case Turn::kControl:
      sdo.startDownload({cia402::kControlword, 0}, controlword_, 2);
  }
}

CanopenSetUp::Outcome CanopenSetUp::answer(const Step& step, NmtState nmt, const CanopenSdo& sdo, CanopenUnits& units) {
  if (step.action == Action::kTellNmt) return Outcome::kNext;
  if (step.action == Action::kReachNmt) {
    if (nmt == stateAfter(static_cast<NmtCommand>(step.value))) return Outcome::kNext;
    if (now_ - asked_at_ < answer_time_) return Outcome::kWait;
    return again(kNmtTime, "does not confirm its network state by a heartbeat");
  }
  switch (sdo.status()) {
    case CanopenSdo::Status::kDone:
      return takeAnswer(step, sdo, units);
    case CanopenSdo::Status::kAborted:
      return refuse(step, sdo);
    case CanopenSdo::Status::kSilent:
      return fail("does not answer");
    default:
      return Outcome::kWait;
  }
}

CanopenSetUp::Outcome CanopenSetUp::takeAnswer(const Step& step, const CanopenSdo& sdo, CanopenUnits& units) {
  switch (step.action) {
    case Action::kCheck:
      if ((sdo.value() & step.mask) == (step.value & step.mask)) return Outcome::kNext;
      return fail("has " + describeHex(sdo.value() & step.mask) + " in object " + describe(step.object) +
                  ", expected " + describeHex(step.value & step.mask));
    case Action::kFindTrace:
      was_configured_ = set_up_before_ && sdo.value() == step.value;
      home_ = home_ || (!was_configured_ && !absolute_encoder_);
      return Outcome::kNext;
    case Action::kReadRating:
      return takeRating(sdo, units);
    case Action::kAwaitMode:
      if (sdo.value() == step.value) return Outcome::kNext;
      return again(kModeTime, "does not take mode of operation " + std::to_string(step.value) + ", shows " +
                                  std::to_string(sdo.signedValue()));
    case Action::kSwitchOn:
    case Action::kHoldPresent:
      return takeTurn(step, sdo);
    case Action::kAwaitHoming:
      return takeHoming(sdo);
    case Action::kReadPosition:
      position_ = sdo.signedValue();
      return Outcome::kNext;
    default:
      return Outcome::kNext;
  }
}

CanopenSetUp::Outcome CanopenSetUp::takeRating(const CanopenSdo& sdo, CanopenUnits& units) {
  if (sdo.value() == 0) return fail("has 0 in object " + describe(effort_.rating) + ": its motor is not configured");
  if (units.needsRating()) units.setRating(sdo.value());
  const double limit = units.effortLimit(tension_max_);
  const double most = effort_.limit_size == 2 ? 0xFFFF : 0x7FFFFFFF;
  if (limit < 1 || limit > most)
    return fail("cannot bound its tension: tension_max needs " + std::to_string(limit) + " in object " +
                describe(effort_.limit) + ", expected 1 to " + std::to_string(most));
  effort_limit_ = static_cast<std::uint32_t>(limit);
  steps_[limit_].value = steps_[limit_ + 1].value = effort_limit_;
  return Outcome::kNext;
}

CanopenSetUp::Outcome CanopenSetUp::takeTurn(const Step& step, const CanopenSdo& sdo) {
  switch (turn_) {
    case Turn::kStatus:
      return takeStatus(sdo);
    case Turn::kPosition:
      position_ = sdo.signedValue();
      turn_ = Turn::kTarget;
      return Outcome::kAgain;
    case Turn::kTarget:
      at_target_ = true;
      turn_ = Turn::kStatus;
      return step.action == Action::kHoldPresent ? Outcome::kNext : Outcome::kAgain;
    default:
      turn_ = Turn::kStatus;
      return Outcome::kAgain;
  }
}

// Before torque comes on, and when it is found on, the target becomes the position: nothing moves.
CanopenSetUp::Outcome CanopenSetUp::takeStatus(const CanopenSdo& sdo) {
  state_ = cia402::calcState(static_cast<std::uint16_t>(sdo.value()));
  const bool enabled = state_ == cia402::State::kOperationEnabled;
  const bool ready = enabled || state_ == cia402::State::kSwitchedOn || state_ == cia402::State::kQuickStopActive;
  if (!ready) at_target_ = false;
  if (enabled && at_target_) return Outcome::kNext;
  turn_ = ready && !at_target_ ? Turn::kPosition : Turn::kControl;
  const bool stuck = state_ == cia402::State::kQuickStopActive && now_ - began_ > kQuickStopTime;
  if (turn_ == Turn::kControl)
    controlword_ = stuck ? cia402::kDisableVoltage : cia402::calcControlword(state_, controlword_);
  return again(kSwitchOnTime, std::string("does not switch on, its state is: ") + cia402::describe(state_));
}

CanopenSetUp::Outcome CanopenSetUp::takeHoming(const CanopenSdo& sdo) {
  constexpr std::uint32_t kDone = cia402::kHomingAttained | cia402::kTargetReached;
  const auto status = static_cast<std::uint16_t>(sdo.value());
  if ((status & cia402::kHomingError) != 0) return fail("reports an error of its homing");
  if (cia402::calcState(status) != cia402::State::kOperationEnabled)
    return fail(std::string("switched off while homing, its state is: ") + cia402::describe(cia402::calcState(status)));
  homed_ = (status & kDone) == kDone;
  return homed_ ? Outcome::kNext : again(homing_timeout_, "does not find its zero in the time given");
}

CanopenSetUp::Outcome CanopenSetUp::again(Duration limit, const std::string& problem) {
  return now_ - began_ < limit ? Outcome::kAgain : fail(problem);
}

CanopenSetUp::Outcome CanopenSetUp::refuse(const Step& step, const CanopenSdo& sdo) {
  const std::uint32_t code = sdo.abortCode();
  const bool lacking =
      code == canopen::kAbortNoObject || code == canopen::kAbortNoSubindex || code == canopen::kAbortReadOnly;
  if (step.need == Need::kMay && lacking) return Outcome::kNext;
  const std::string value = step.action == Action::kWrite ? " = " + describeHex(step.value) : "";
  return fail("refuses object " + describe(sdo.object()) + value + ": " + canopen::describeAbort(code) + " (" +
              describeHex(code) + ")");
}

CanopenSetUp::Outcome CanopenSetUp::fail(const std::string& problem) {
  problem_ = problem;
  return Outcome::kFailed;
}

}  // namespace sinew
