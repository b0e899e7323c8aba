#include "sinew/hardware/hardware_driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "sinew/hardware/actuator_fault.h"

namespace sinew {
namespace {

constexpr double kMaxIntervalPeriods = 2;  // a stalled cycle may not leap further than this many rate steps
constexpr double kProbePeriod = 0.5;       // s between looks at devices that are not served

std::vector<CommandLimiter::Limits> makeLimits(const HardwareDescription& h) {
  std::vector<CommandLimiter::Limits> limits;
  for (const ActuatorDescription& a : h.actuators) limits.push_back({a.min, a.max, a.rate_max});
  return limits;
}

std::string format(const char* text, double value) {
  char out[128];
  std::snprintf(out, sizeof out, text, value);
  return out;
}

// "1.20 mm", "3.4 kPa"
std::string describeDistance(double distance, Quantity quantity) {
  return quantity == Quantity::kPressure ? format("%.1f kPa", 1e-3 * distance) : format("%.2f mm", 1e3 * distance);
}

DriverEvent eventOf(DriverRequest request) {
  switch (request) {
    case DriverRequest::kInit:
    case DriverRequest::kHome:
      return DriverEvent::kInit;
    case DriverRequest::kRecover:
      return DriverEvent::kRecover;
    case DriverRequest::kHalt:
      return DriverEvent::kHalt;
    case DriverRequest::kEmergency:
      return DriverEvent::kEmergency;
    case DriverRequest::kShutdown:
      break;
  }
  return DriverEvent::kShutdown;
}

const char* reasonOf(DriverRequest request) {
  switch (request) {
    case DriverRequest::kInit:
      return "connecting and homing";
    case DriverRequest::kHome:
      return "homing";
    case DriverRequest::kRecover:
      return "recovering";
    case DriverRequest::kHalt:
      return "halted: holding until recover";
    case DriverRequest::kEmergency:
      return "emergency stop: safe until recover";
    case DriverRequest::kShutdown:
      break;
  }
  return "shut down";
}

bool wakesDevices(DriverRequest request) {
  return request == DriverRequest::kInit || request == DriverRequest::kHome || request == DriverRequest::kRecover;
}

}  // namespace

HardwareDriver::HardwareDriver(const HardwareDescription& description, std::unique_ptr<DeviceBus> devices)
    : description_(description),
      devices_(std::move(devices)),
      limiter_(makeLimits(description), kMaxIntervalPeriods / description.rate),
      homing_(description.actuators),
      watch_(description.actuators),
      release_(description.actuators.size(), description.relax_time),
      keep_zero_(description.actuators.size(), false),
      target_(description.actuators.size(), 0.0),
      measured_(description.actuators.size(), 0.0) {
  expected_.fill(std::numeric_limits<double>::quiet_NaN());
  report_.zero_counts.resize(target_.size());
  report_.reason.reserve(256);
  report_.reason = "not initialised";
  fillReport(Time{});
}

// --- Events ---

bool HardwareDriver::request(DriverRequest request) {
  if (request == DriverRequest::kHome && state_ != DriverState::kReady) return false;
  if (report_.emergency_stop && wakesDevices(request)) return false;
  home_all_ = request != DriverRequest::kRecover;
  bool taken = handle(eventOf(request), reasonOf(request));
  if (request == DriverRequest::kEmergency && !taken && state_ != DriverState::kOff) {
    startRelease(false);  // after a halt, say, which lets nothing go
    taken = true;
  }
  fillReport(last_update_);
  return taken || (request == DriverRequest::kShutdown && state_ == DriverState::kOff);
}

void HardwareDriver::setEmergencyStop(bool pressed) {
  if (pressed == report_.emergency_stop) return;
  report_.emergency_stop = pressed;
  if (pressed) request(DriverRequest::kEmergency);
}

bool HardwareDriver::handle(DriverEvent event, const std::string& reason) {
  const DriverState next = nextState(state_, event);
  if (next == state_) return false;
  enter(next, event);
  report_.reason = reason;
  return true;
}

void HardwareDriver::enter(DriverState state, DriverEvent event) {
  const bool powered = state_ != DriverState::kOff;
  const bool from_holding = state_ == DriverState::kHolding;
  state_ = state;
  switch (state) {
    case DriverState::kOff:
      gate_.release();
      if (powered) startRelease(true);
      break;
    case DriverState::kInitialising:
      gate_.release();
      release_.stop();
      watch_.reset();
      set_up_ = SetUp::kOpen;
      break;
    case DriverState::kReady:
      gate_.release();
      if (!from_holding) limiter_.reset(measured_);  // a held set point stays: nothing moves
      target_ = limiter_.applied();
      break;
    case DriverState::kSafe:
      if (event != DriverEvent::kHalt) startRelease(false);
      break;
    case DriverState::kFault:
      startRelease(false);
      break;
    case DriverState::kHolding:
      target_ = limiter_.applied();
      break;
    case DriverState::kActive:
      break;
  }
}

// --- Commands ---

CommandVerdict HardwareDriver::offer(const Command& command) {
  CommandVerdict verdict = gate_.check(command);
  if (verdict == CommandVerdict::kAccepted && !mayFollow(command)) verdict = CommandVerdict::kState;
  if (verdict == CommandVerdict::kAccepted)
    follow(command);
  else
    gate_.refuse(verdict);
  return verdict;
}

void HardwareDriver::follow(const Command& command) {
  gate_.accept(command);
  std::copy(command.value.begin(), command.value.begin() + static_cast<std::ptrdiff_t>(target_.size()),
            target_.begin());
  expected_ = command.effort;
  if (command.status == CommandStatus::kHeld && last_status_ != CommandStatus::kHeld) held_since_ = command.received;
  last_status_ = command.status;
  if (handle(DriverEvent::kCommand, "")) held_since_ = command.received;
}

// Out of ready and holding, only a command that asks for no jump is followed.
bool HardwareDriver::mayFollow(const Command& command) {
  if (!takesCommands(state_)) return false;
  if (state_ == DriverState::kActive) return true;
  for (std::size_t i = 0; i < target_.size(); ++i) {
    const ActuatorDescription& a = description_.actuators[i];
    const double step = a.rate_max / description_.rate;
    const double from_applied = std::abs(command.value[i] - limiter_.applied()[i]);
    const double from_measured = std::abs(command.value[i] - measured_[i]);
    const bool ready = state_ == DriverState::kReady;
    const double off = ready ? std::min(from_applied, from_measured) : from_applied;
    if (off <= std::max(step, a.seedTolerance())) continue;
    report_.reason = a.name + ": command refused, " + describeDistance(off, a.quantity) +
                     (ready ? " from what is measured" : " from the held set point; call recover");
    return false;
  }
  return true;
}

void HardwareDriver::checkCommands(Time now) {
  const double age = gate_.age(now);
  if (state_ == DriverState::kActive && age > description_.command_timeout) {
    holding_since_ = now;
    handle(DriverEvent::kCommandLost, format("no command for %.0f ms", 1e3 * description_.command_timeout));
  }
  const bool held = state_ == DriverState::kActive && last_status_ == CommandStatus::kHeld;
  const bool too_long = (held && seconds(now - held_since_) > description_.hold_limit) ||
                        (state_ == DriverState::kHolding && seconds(now - holding_since_) > description_.hold_limit);
  if (!too_long) return;
  const char* why =
      held ? "controller held for %.2f s: safe until recover" : "no command for %.2f s more: safe until recover";
  handle(DriverEvent::kHoldLimit, format(why, description_.hold_limit));
}

// --- One cycle ---

const DriverReport& HardwareDriver::update(Time now) {
  const double interval = any_update_ ? seconds(now - last_update_) : 1 / description_.rate;
  last_update_ = now;
  any_update_ = true;
  if (takesCommands(state_)) checkCommands(now);
  if (servesDevices(state_))
    serve(now, interval);
  else if (state_ == DriverState::kInitialising)
    updateInitialising(now, interval);
  else
    updateIdle(now);
  ++report_.cycles;
  fillReport(now);
  return report_;
}

void HardwareDriver::serve(Time now, double interval) {
  if (state_ == DriverState::kActive)
    limiter_.update(target_, interval);
  else
    expected_.fill(std::numeric_limits<double>::quiet_NaN());
  if (!exchange(limiter_.applied(), now) || !checkHealth()) return;
  if (watch_.update(devices_->readings(), limiter_.applied(), expected_.data(), interval)) return;
  for (std::size_t i = 0; i < target_.size(); ++i)
    if (watch_.fault(static_cast<int>(i)) != 0) return fail(i, watch_.fault(static_cast<int>(i)));
}

bool HardwareDriver::exchange(const std::vector<double>& set_points, Time now) {
  const bool usable = devices_->writeSetPoints(set_points.data(), now) && devices_->read(now);
  if (!usable) lose(devices_->problem());
  return usable;
}

bool HardwareDriver::checkHealth() {
  const std::vector<ActuatorReading>& readings = devices_->readings();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (readings[i].fault == 0) continue;
    fail(i, readings[i].fault);
    return false;
  }
  return true;
}

void HardwareDriver::fail(std::size_t actuator, std::uint32_t fault) {
  const ActuatorDescription& a = description_.actuators[actuator];
  const std::string detail = devices_->faultDetail(static_cast<int>(actuator));
  lose(a.name + " (id " + std::to_string(a.id) + ") " + describeFault(fault) +
       (detail.empty() ? "" : " (" + detail + ")"));
}

void HardwareDriver::lose(const std::string& reason) {
  if (handle(DriverEvent::kFailure, reason)) last_probe_ = last_update_;
}

// --- Set-up ---

void HardwareDriver::updateInitialising(Time now, double interval) {
  switch (set_up_) {
    case SetUp::kOpen:
      openLines();
      break;
    case SetUp::kConfigure: {
      const SetUpProgress progress = devices_->updateSetUp(now);
      if (progress == SetUpProgress::kFailed) lose(devices_->problem());
      if (progress == SetUpProgress::kDone) set_up_ = SetUp::kFirstReading;
      for (std::size_t i = 0; i < target_.size(); ++i) target_[i] = devices_->readings()[i].measured;
      break;
    }
    case SetUp::kFirstReading:
      takeFirstReading(now);
      break;
    case SetUp::kHoming:
      updateHoming(interval, now);
      break;
  }
}

void HardwareDriver::openLines() {
  std::string why;
  if (!devices_->open(why)) return lose(why);
  devices_->startSetUp(home_all_);
  set_up_ = SetUp::kConfigure;
}

void HardwareDriver::takeFirstReading(Time now) {
  if (!exchange(target_, now) || !checkHealth()) return;
  const std::vector<ActuatorReading>& readings = devices_->readings();
  if (!std::all_of(readings.begin(), readings.end(), [](const ActuatorReading& r) { return r.valid; })) return;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const ActuatorDescription& a = description_.actuators[i];
    const bool by_itself = a.quantity == Quantity::kPressure || a.cable.homing.method == HomingMethod::kDevice;
    keep_zero_[i] = readings[i].zero_valid && (!home_all_ || by_itself);
  }
  homing_.start(readings, keep_zero_);
  set_up_ = SetUp::kHoming;
}

void HardwareDriver::updateHoming(double interval, Time now) {
  const CableHoming::Progress progress = homing_.update(devices_->readings(), interval);
  if (progress == CableHoming::Progress::kDone) return finishHoming();
  if (progress == CableHoming::Progress::kFailed)
    return lose(description_.actuators[static_cast<std::size_t>(homing_.failed())].name +
                " found no tension while homing; is the cable on its spool?");
  if (exchange(homing_.setPoints(), now)) checkHealth();
}

void HardwareDriver::finishHoming() {
  for (std::size_t i = 0; i < keep_zero_.size(); ++i)
    if (!keep_zero_[i]) devices_->setZero(static_cast<int>(i), 0);
  for (std::size_t i = 0; i < measured_.size(); ++i) measured_[i] = devices_->readings()[i].measured;
  handle(DriverEvent::kPrepared, "holding what is measured, waiting for the first command");
}

// --- Letting go ---

void HardwareDriver::startRelease(bool all) {
  if (!devices_->isOpen()) return;
  std::vector<bool> which(target_.size());
  for (std::size_t i = 0; i < which.size(); ++i)
    which[i] = all || description_.actuators[i].on_timeout != OnTimeout::kHold;
  release_.start(which);
}

// The effort that each had goes to nothing over relax_time, then it is switched off.
void HardwareDriver::updateRelease(Time now) {
  const double share = release_.share(now);
  if (share > 0) {
    devices_->relax(release_.which(), share);
    return;
  }
  devices_->switchOff(release_.which());
  release_.stop();
}

void HardwareDriver::updateIdle(Time now) {
  if (release_.active()) return updateRelease(now);
  if (state_ == DriverState::kOff) {
    devices_->close();
  } else if (now - last_probe_ >= duration(kProbePeriod)) {
    last_probe_ = now;
    probe(now);
  }
}

// Rare enough not to feed any device's watchdog. The link comes back by itself; moving again needs recover.
void HardwareDriver::probe(Time now) {
  std::string why;
  if (!devices_->open(why)) return;
  if (!devices_->read(now)) return lose(devices_->problem());
  const std::vector<ActuatorReading>& readings = devices_->readings();
  const bool all =
      std::all_of(readings.begin(), readings.end(), [](const ActuatorReading& r) { return r.missing == 0; });
  constexpr const char* kBack = "; all devices answer now, call recover";
  if (state_ == DriverState::kFault && all && report_.reason.find(kBack) == std::string::npos) report_.reason += kBack;
}

void HardwareDriver::fillReport(Time now) {
  report_.actuators = devices_->readings();
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    measured_[i] = report_.actuators[i].measured;
    report_.actuators[i].fault |= watch_.fault(static_cast<int>(i));
    report_.zero_counts[i] = report_.actuators[i].zero_valid ? devices_->zeroCounts(static_cast<int>(i))
                                                             : std::numeric_limits<double>::quiet_NaN();
  }
  report_.state = state_;
  // Where nothing holds a set point, it follows the measurement, so that whoever commands next starts from there.
  report_.applied = takesCommands(state_) ? limiter_.applied() : measured_;
  report_.command_age = gate_.age(now);
  report_.session = gate_.session();
  report_.sequence = gate_.sequence();
  report_.commands = gate_.counters();
  report_.bus = devices_->counters();
  report_.relaxing = release_.active();
}

}  // namespace sinew
