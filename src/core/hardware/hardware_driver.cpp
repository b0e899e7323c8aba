#include "sinew/hardware/hardware_driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sinew {
namespace {

constexpr double kSeedTolerance = 1e-4;    // m by which a first command may differ from the measurement
constexpr double kMaxIntervalPeriods = 2;  // a stalled cycle may not leap further than this many rate steps
constexpr double kProbePeriod = 0.5;       // s between looks at devices that are not served

std::vector<CommandLimiter::Limits> makeLimits(const HardwareDescription& h) {
  std::vector<CommandLimiter::Limits> limits;
  for (const ActuatorDescription& a : h.actuators)
    limits.push_back({a.displacement_min, a.displacement_max, a.rate_max});
  return limits;
}

std::string format(const char* text, double value) {
  char out[128];
  std::snprintf(out, sizeof out, text, value);
  return out;
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
    case DriverRequest::kShutdown:
      break;
  }
  return "shut down";
}

}  // namespace

HardwareDriver::HardwareDriver(const HardwareDescription& description, LineFactory open_line)
    : description_(description),
      open_line_(std::move(open_line)),
      chain_(description),
      limiter_(makeLimits(description), kMaxIntervalPeriods / description.rate),
      homing_(description.actuators),
      keep_zero_(description.actuators.size(), false),
      target_(description.actuators.size(), 0.0),
      tension_limits_(description.actuators.size(), 0.0),
      measured_(description.actuators.size(), 0.0) {
  release_.which.assign(target_.size(), false);
  release_.tension.assign(target_.size(), 0.0);
  report_.reason.reserve(256);
  report_.reason = "not initialised";
  fillReport(Time{});
}

// --- Events ---

bool HardwareDriver::request(DriverRequest request) {
  if (request == DriverRequest::kHome && state_ != DriverState::kReady) return false;
  home_all_ = request == DriverRequest::kRecover ? home_all_ && state_ == DriverState::kOff : true;
  const bool taken = handle(eventOf(request), reasonOf(request));
  fillReport(last_update_);
  return taken || (request == DriverRequest::kShutdown && state_ == DriverState::kOff);
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
      release_.active = false;
      set_up_ = SetUp::kOpen;
      break;
    case DriverState::kReady:
      gate_.release();
      if (!from_holding) limiter_.reset(measured_);  // a held set point stays: nothing moves
      target_ = limiter_.applied();
      break;
    case DriverState::kSafe:
      if (event == DriverEvent::kHoldLimit) startRelease(false);
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
  if (verdict != CommandVerdict::kAccepted) {
    gate_.refuse(verdict);
    return verdict;
  }
  gate_.accept(command);
  std::copy(command.value.begin(), command.value.begin() + static_cast<std::ptrdiff_t>(target_.size()),
            target_.begin());
  if (command.status == CommandStatus::kHeld && last_status_ != CommandStatus::kHeld) held_since_ = command.received;
  last_status_ = command.status;
  if (handle(DriverEvent::kCommand, "")) held_since_ = command.received;
  return verdict;
}

// Out of ready and holding, only a command that asks for no jump is followed.
bool HardwareDriver::mayFollow(const Command& command) {
  if (!takesCommands(state_)) return false;
  if (state_ == DriverState::kActive) return true;
  for (std::size_t i = 0; i < target_.size(); ++i) {
    const double step = description_.actuators[i].rate_max / description_.rate;
    const double from_applied = std::abs(command.value[i] - limiter_.applied()[i]);
    const double from_measured = std::abs(command.value[i] - measured_[i]);
    const double off = state_ == DriverState::kReady ? std::min(from_applied, from_measured) : from_applied;
    if (off <= std::max(step, kSeedTolerance)) continue;
    const bool ready = state_ == DriverState::kReady;
    report_.reason =
        description_.actuators[i].name + ": command refused, " +
        format(ready ? "%.2f mm from the measured position" : "%.2f mm from the held set point; call recover",
               1e3 * off);
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
  if (state_ == DriverState::kActive) limiter_.update(target_, interval);
  if (!checkLine(chain_.writeSetPoints(limiter_.applied()) && chain_.read(now))) return;
  if (!chain_.checkHealth()) lose(chain_.problem());
}

bool HardwareDriver::checkLine(bool usable) {
  if (!usable) lose("the line to the devices is gone");
  return usable;
}

void HardwareDriver::lose(const std::string& reason) {
  if (handle(DriverEvent::kFailure, reason) && line_ != nullptr) last_probe_ = last_update_;
}

// --- Set-up ---

void HardwareDriver::updateInitialising(Time now, double interval) {
  switch (set_up_) {
    case SetUp::kOpen:
      openLine();
      break;
    case SetUp::kConfigure: {
      const ServoChain::Progress progress = chain_.updateSetUp(now);
      if (progress == ServoChain::Progress::kFailed) lose(chain_.problem());
      if (progress == ServoChain::Progress::kDone) set_up_ = SetUp::kFirstReading;
      break;
    }
    case SetUp::kFirstReading: {
      if (!checkLine(chain_.read(now))) return;
      if (!chain_.checkHealth()) return lose(chain_.problem());
      const auto& servos = chain_.readings();
      if (!std::all_of(servos.begin(), servos.end(), [](const ServoReading& r) { return r.valid; })) return;
      for (std::size_t i = 0; i < servos.size(); ++i) keep_zero_[i] = !home_all_ && servos[i].zero_valid;
      homing_.start(servos, keep_zero_);
      set_up_ = SetUp::kHoming;
      break;
    }
    case SetUp::kHoming:
      updateHoming(interval, now);
      break;
  }
}

void HardwareDriver::openLine() {
  std::string why = "no line";
  line_ = open_line_(why);
  chain_.attach(line_.get());
  if (line_ == nullptr) return lose(why);
  chain_.startSetUp();
  set_up_ = SetUp::kConfigure;
}

void HardwareDriver::updateHoming(double interval, Time now) {
  const CableHoming::Progress progress = homing_.update(chain_.readings(), interval);
  if (progress == CableHoming::Progress::kDone) return finishHoming();
  if (progress == CableHoming::Progress::kFailed)
    return lose(description_.actuators[static_cast<std::size_t>(homing_.failed())].name +
                " found no tension while homing; is the cable on its spool?");
  if (!checkLine(chain_.writeSetPoints(homing_.setPoints()) && chain_.read(now))) return;
  if (!chain_.checkHealth()) lose(chain_.problem());
}

void HardwareDriver::finishHoming() {
  for (std::size_t i = 0; i < keep_zero_.size(); ++i)
    if (!keep_zero_[i]) chain_.setZero(static_cast<int>(i), 0);
  for (std::size_t i = 0; i < measured_.size(); ++i) measured_[i] = chain_.readings()[i].displacement;
  handle(DriverEvent::kPrepared, "holding the measured position, waiting for the first command");
}

// --- Letting go ---

void HardwareDriver::startRelease(bool all) {
  release_.active = line_ != nullptr;
  release_.started = false;
  for (std::size_t i = 0; i < release_.which.size(); ++i) {
    release_.which[i] = all || description_.actuators[i].on_timeout == OnTimeout::kRelax;
    const double tension_max = description_.actuators[i].tension_max;
    release_.tension[i] = std::min(tension_max, std::max(0., chain_.readings()[i].tension));
    tension_limits_[i] = tension_max;
  }
  if (std::none_of(release_.which.begin(), release_.which.end(), [](bool b) { return b; })) release_.active = false;
}

// The tension that each cable had goes to nothing over relax_time, then the torque goes off.
void HardwareDriver::updateRelease(Time now) {
  if (!release_.started) release_.start = now;
  release_.started = true;
  const double left = description_.relax_time - seconds(now - release_.start);
  if (left <= 0) {
    release_.active = false;
    chain_.release(release_.which);
    if (!chain_.release(release_.which)) line_.reset();  // sync writes have no answer: said twice
    return;
  }
  for (std::size_t i = 0; i < tension_limits_.size(); ++i)
    if (release_.which[i]) tension_limits_[i] = release_.tension[i] * left / description_.relax_time;
  if (!chain_.writeTensionLimits(tension_limits_)) release_.active = false;
}

void HardwareDriver::updateIdle(Time now) {
  if (release_.active) return updateRelease(now);
  if (state_ == DriverState::kOff) {
    chain_.attach(nullptr);
    line_.reset();
  } else if (now - last_probe_ >= duration(kProbePeriod)) {
    last_probe_ = now;
    probe(now);
  }
}

// Rare enough not to feed any bus watchdog. The link comes back by itself; moving again needs recover.
void HardwareDriver::probe(Time now) {
  if (line_ == nullptr) {
    std::string why;
    line_ = open_line_(why);
    chain_.attach(line_.get());
    if (line_ == nullptr) return;
  }
  if (!chain_.read(now)) {
    chain_.attach(nullptr);
    line_.reset();
    lose("the line to the devices is gone");
    return;
  }
  const auto& servos = chain_.readings();
  const bool all = std::all_of(servos.begin(), servos.end(), [](const ServoReading& r) { return r.missing == 0; });
  constexpr const char* kBack = "; all devices answer now, call recover";
  if (state_ == DriverState::kFault && all && report_.reason.find(kBack) == std::string::npos) report_.reason += kBack;
}

void HardwareDriver::fillReport(Time now) {
  const std::vector<ServoReading>& servos = chain_.readings();
  for (std::size_t i = 0; i < measured_.size(); ++i) measured_[i] = servos[i].displacement;
  // Where nothing holds a set point, it follows the measurement, so that whoever commands next starts from there.
  const bool holds = takesCommands(state_);
  report_.state = state_;
  report_.servos = servos;
  report_.applied = holds ? limiter_.applied() : measured_;
  report_.command_age = gate_.age(now);
  report_.session = gate_.session();
  report_.sequence = gate_.sequence();
  report_.commands = gate_.counters();
  report_.bus = chain_.counters();
  report_.relaxing = release_.active;
}

}  // namespace sinew
