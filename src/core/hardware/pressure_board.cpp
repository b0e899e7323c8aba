#include "sinew/hardware/pressure_board.h"

#include <algorithm>
#include <cmath>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr int kTries = 3;                              // of a set-up request on a bad line
constexpr double kRampMargin = 1.2;                    // of the board's ramp over the driver's rate
constexpr double kMinTimeout = 0.02, kMaxTimeout = 5;  // s that a board takes

const char* describe(PressureReason reason) {
  switch (reason) {
    case PressureReason::kAccepted:
      return "accepted";
    case PressureReason::kUnknownType:
      return "unknown message";
    case PressureReason::kWrongLength:
      return "message of a wrong length";
    case PressureReason::kWrongVersion:
      return "another version of the protocol";
    case PressureReason::kWrongCount:
      return "another number of channels";
    case PressureReason::kOutOfRange:
      return "value out of range";
    case PressureReason::kNotArmed:
      return "not configured since it started";
    case PressureReason::kStale:
      return "sequence not rising: another master speaks to it";
    case PressureReason::kBusy:
      return "not now";
  }
  return "unknown reason";
}

struct FaultMeaning {
  PressureChannelFault bit;
  std::uint32_t fault;
  const char* words;
};

constexpr FaultMeaning kMeanings[] = {
    {kChannelSensor, kFaultSensor, "pressure sensor open or short"},
    {kChannelOverpressure, kFaultPressure, "pressure above the board's limit"},
    {kChannelTimeout, kFaultWatchdog, "no set point came in time"},
    {kChannelStop, kFaultDevice, "emergency stop"},
    {kChannelSupply, kFaultVoltage, "supply voltage out of range"},
    {kChannelTemperature, kFaultOverheated, "board too hot"},
    {kChannelSource, kFaultFollowing, "no pressure from the pump"},
};

std::uint32_t toFault(std::uint8_t faults) {
  std::uint32_t fault = 0;
  for (const FaultMeaning& m : kMeanings)
    if ((faults & m.bit) != 0) fault |= m.fault;
  return fault;
}

std::string describeFaults(std::uint8_t faults) {
  std::string words;
  for (const FaultMeaning& m : kMeanings)
    if ((faults & m.bit) != 0) words += (words.empty() ? "" : ", ") + std::string(m.words);
  return words;
}

PressureMode modeOf(const PressureChannelState& channel) {
  return static_cast<PressureMode>(channel.status & 3);
}

std::string format(double pascal) {
  return std::to_string(std::lround(pascal)) + " Pa";
}

void checkTiming(const DeviceTiming& timing) {
  if (timing.watchdog < std::max(kMinTimeout, 2 * timing.period) || timing.watchdog > kMaxTimeout)
    throw ConfigError("watchdog of a pressure board", std::to_string(timing.watchdog),
                      "s, at least two periods, 0.02 to 5");
}

void checkActuator(const PressureActuator& a) {
  const ActuatorBounds& b = a.bounds;
  if (a.settings.pressure_limit < b.max)
    throw ConfigError(b.name + ".pressure_limit", format(a.settings.pressure_limit),
                      "at least the actuator's max, " + format(b.max));
  if (kRampMargin * b.rate_max < 1 || kRampMargin * b.rate_max > kMaxPressureRamp)
    throw ConfigError(b.name + ".rate_max", std::to_string(b.rate_max), "Pa/s, 1 to 8e6");
}

}  // namespace

PressureBoard::PressureBoard(int address, const DeviceTiming& timing, std::vector<PressureActuator> actuators)
    : address_(static_cast<std::uint8_t>(address)),
      timing_(timing),
      actuators_(std::move(actuators)),
      channels_(actuators_.size()),
      readings_(actuators_.size()) {
  checkTiming(timing_);
  if (actuators_.empty())
    throw ConfigError("actuators of pressure board " + std::to_string(address), "none", "at least one");
  std::vector<bool> used(kMaxPressureChannels, false);
  for (const PressureActuator& a : actuators_) {
    checkActuator(a);
    const auto channel = static_cast<std::size_t>(a.settings.channel);
    if (used[channel])
      throw ConfigError(a.bounds.name + ".channel", std::to_string(channel) + " twice", "each channel of a board once");
    used[channel] = true;
  }
  for (ActuatorReading& r : readings_) r.zero_valid = true;
  problem_.reserve(256);
}

void PressureBoard::fail(const std::string& what) {
  progress_ = SetUpProgress::kFailed;
  problem_ = actuators_.front().bounds.name + " (board " + std::to_string(address_) + ") " + what;
}

void PressureBoard::failAt(std::size_t i, const std::string& what) {
  progress_ = SetUpProgress::kFailed;
  problem_ = actuators_[i].bounds.name + " (board " + std::to_string(address_) + ", channel " +
             std::to_string(actuators_[i].settings.channel) + ") " + what;
}

// --- Requests ---

void PressureBoard::open(PressureType type) {
  request_.type = type;
  request_.sequence = ++sequence_;
  answered_ = false;
  read_ = false;
}

PressureConfiguration PressureBoard::makeConfiguration() const {
  PressureConfiguration c;
  c.timeout = static_cast<std::uint16_t>(std::lround(1e3 * timing_.watchdog));
  c.count = identity_.channels;
  for (const PressureActuator& a : actuators_) {
    PressureChannelConfiguration& channel = c.channels[static_cast<std::size_t>(a.settings.channel)];
    channel.maximum = static_cast<std::int32_t>(std::lround(a.settings.pressure_limit));
    channel.ramp = static_cast<std::uint32_t>(std::lround(kRampMargin * a.bounds.rate_max));
    channel.on_timeout = a.settings.on_silence;
  }
  return c;
}

void PressureBoard::prepareSetPoints(const double* set_points) {
  for (std::size_t i = 0; i < channels_.size(); ++i)
    if (!channels_[i].relaxing && std::isfinite(set_points[i])) channels_[i].set_point = set_points[i];
  prepareSetPoints();
}

void PressureBoard::prepareSetPoints() {
  open(PressureType::kSetPoints);
  request_.count = identity_.channels;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const auto channel = static_cast<std::size_t>(actuators_[i].settings.channel);
    const PressureChannelConfiguration& limits = request_.configuration.channels[channel];
    PressureSetPoint& s = request_.set_points[channel];
    s.mode = channels_[i].mode;
    s.limit = limits.maximum;
    s.ramp = limits.ramp;
    const auto wanted = static_cast<std::int32_t>(std::lround(std::clamp(channels_[i].set_point, -1e7, 1e7)));
    s.pressure = std::clamp(wanted, std::min(identity_.range_min, s.limit), s.limit);
  }
}

void PressureBoard::prepareRead() {
  open(PressureType::kReadState);
}

void PressureBoard::relax(const bool* which, double share) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!which[i]) continue;
    Channel& c = channels_[i];
    if (!c.relaxing) c.relaxed_from = readings_[i].measured;
    c.relaxing = true;
    c.set_point = std::clamp(share, 0., 1.) * c.relaxed_from;
    if (share <= 0) c.mode = PressureMode::kVent;
  }
}

void PressureBoard::switchOff(const bool* which) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (!which[i]) continue;
    channels_[i].relaxing = true;
    channels_[i].mode = PressureMode::kVent;
  }
}

// --- Answers ---

bool PressureBoard::answers(const PressureAnswer& a) const {
  if (answered_ || a.sequence != request_.sequence) return false;
  switch (request_.type) {
    case PressureType::kHello:
      return a.type == PressureType::kIdentity || (a.type == PressureType::kError && a.refused == request_.type);
    case PressureType::kConfigure:
      return a.type == PressureType::kConfiguration || (a.type == PressureType::kError && a.refused == request_.type);
    default:
      if (a.type == PressureType::kError) return a.refused == request_.type;
      return a.type == PressureType::kState && a.state.count == identity_.channels;
  }
}

bool PressureBoard::take(const PressureAnswer& answer) {
  if (!answers(answer)) return false;
  answered_ = true;
  refusal_ = answer.type == PressureType::kError   ? answer.reason
             : answer.type == PressureType::kState ? answer.state.refusal
                                                   : PressureReason::kAccepted;
  if (refusal_ != PressureReason::kAccepted) ++refusals_;
  if (progress_ == SetUpProgress::kBusy) takeSetUp(answer);
  if (answer.type == PressureType::kState) takeState(answer.state);
  return true;
}

// Uptime falls only when a board restarts, or from 2^32 ms to 0.
bool PressureBoard::hasRestarted(const PressureState& state) const {
  const std::uint32_t advance = state.uptime - uptime_;
  return (state.flags & kBoardArmed) == 0 || advance >= 1u << 31;
}

void PressureBoard::takeState(const PressureState& state) {
  read_ = true;
  const bool restarted = enabled_ && hasRestarted(state);
  for (std::size_t i = 0; i < readings_.size(); ++i) {
    takeChannel(i, state);
    if (restarted) readings_[i].fault |= kFaultOff;
  }
  uptime_ = state.uptime;
}

void PressureBoard::takeChannel(std::size_t i, const PressureState& state) {
  const PressureChannelState& channel = channelOf(i, state);
  ActuatorReading& r = readings_[i];
  r.measured = r.effort = channel.pressure;
  r.voltage = 1e-3 * state.supply;
  r.temperature = 0.1 * state.temperature;
  if (!enabled_) return;
  channels_[i].faults = static_cast<std::uint8_t>(channels_[i].faults | channel.faults);
  r.fault |= toFault(channel.faults);
  const bool should_regulate = channels_[i].mode == PressureMode::kRegulate;
  if (should_regulate && channel.faults == 0 && modeOf(channel) != PressureMode::kRegulate) r.fault |= kFaultOff;
}

void PressureBoard::endCycle() {
  for (ActuatorReading& r : readings_) {
    r.valid = read_;
    r.missing = read_ ? 0 : r.missing + 1;
    if (r.missing >= timing_.missing_limit) r.fault |= kFaultSilent;
  }
  read_ = false;
}

std::string PressureBoard::faultDetail(int i) const {
  const auto k = static_cast<std::size_t>(i);
  std::string words = describeFaults(channels_[k].faults);
  if ((readings_[k].fault & kFaultOff) != 0) words += (words.empty() ? "" : ", ") + std::string("board has restarted");
  if (enabled_ && refusal_ != PressureReason::kAccepted)
    words += (words.empty() ? "" : ", ") + std::string("board refuses: ") + describe(refusal_);
  return words;
}

// --- Set-up ---

void PressureBoard::startSetUp() {
  progress_ = SetUpProgress::kBusy;
  phase_ = Phase::kHello;
  tries_ = 0;
  problem_.clear();
  enabled_ = false;
  answered_ = true;
  for (Channel& c : channels_) c = Channel{};
  for (ActuatorReading& r : readings_) {
    r.fault = 0;
    r.missing = 0;
  }
}

bool PressureBoard::prepareSetUp(bool enable) {
  if (progress_ != SetUpProgress::kBusy || (phase_ == Phase::kEnable && !enable)) return false;
  switch (phase_) {
    case Phase::kHello:
      open(PressureType::kHello);
      break;
    case Phase::kClear:
      open(PressureType::kClearFaults);
      request_.mask = static_cast<std::uint16_t>((1u << identity_.channels) - 1);
      break;
    case Phase::kConfigure:
      open(PressureType::kConfigure);
      request_.configuration = makeConfiguration();
      break;
    case Phase::kRead:
      prepareRead();
      break;
    case Phase::kEnable:
      prepareSetPoints();
      break;
  }
  return true;
}

void PressureBoard::missSetUp() {
  if (progress_ != SetUpProgress::kBusy || ++tries_ < kTries) return;
  fail("does not answer; is it powered, and its address " + std::to_string(address_) + "?");
}

void PressureBoard::takeSetUp(const PressureAnswer& answer) {
  tries_ = 0;
  const bool standing = phase_ == Phase::kClear && refusal_ == PressureReason::kBusy;
  if (phase_ == Phase::kConfigure && refusal_ == PressureReason::kBusy)
    return fail("still holds pressure under another configuration; vent it, or switch it off and on");
  if (refusal_ != PressureReason::kAccepted && !standing)
    return fail(std::string("refuses its set-up: ") + describe(refusal_));
  switch (phase_) {
    case Phase::kHello:
      identity_ = answer.identity;
      if (checkIdentity()) phase_ = Phase::kClear;
      break;
    case Phase::kClear:
      if (standing && checkState(answer.state)) fail("has a fault that stands");
      if (!standing) phase_ = Phase::kConfigure;
      break;
    case Phase::kConfigure:
      if (!(answer.configuration == request_.configuration)) return fail("has not taken its configuration");
      phase_ = Phase::kRead;
      break;
    case Phase::kRead:
      if (checkState(answer.state)) seedSetPoints(answer.state);
      break;
    case Phase::kEnable:
      if (!checkState(answer.state)) break;
      enabled_ = true;
      progress_ = SetUpProgress::kDone;
  }
}

bool PressureBoard::checkIdentity() {
  if (identity_.version != kPressureProtocolVersion)
    return fail("speaks version " + std::to_string(identity_.version) + " of the protocol, expected 1"), false;
  if (identity_.channels < 1 || identity_.channels > kMaxPressureChannels)
    return fail("tells of " + std::to_string(identity_.channels) + " channels, expected 1 to 16"), false;
  for (std::size_t i = 0; i < actuators_.size(); ++i) {
    const PressureActuator& a = actuators_[i];
    if (a.settings.channel >= identity_.channels)
      return failAt(i, "does not exist: the board has " + std::to_string(identity_.channels) + " channels"), false;
    if (a.settings.pressure_limit > identity_.range_max || a.bounds.min < identity_.range_min)
      return failAt(i, "is to work from " + format(a.bounds.min) + " to " + format(a.settings.pressure_limit) +
                           ", its board from " + format(identity_.range_min) + " to " + format(identity_.range_max)),
             false;
  }
  return true;
}

bool PressureBoard::checkState(const PressureState& state) {
  for (std::size_t i = 0; i < actuators_.size(); ++i) {
    const std::uint8_t faults = channelOf(i, state).faults;
    if (faults != 0) return failAt(i, "has a fault: " + describeFaults(faults)), false;
  }
  return true;
}

// The set point becomes the measured pressure before the channel regulates: nothing moves.
void PressureBoard::seedSetPoints(const PressureState& state) {
  sequence_ = state.accepted;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    channels_[i].set_point = channelOf(i, state).pressure;
    channels_[i].mode = PressureMode::kRegulate;
  }
  phase_ = Phase::kEnable;
}

}  // namespace sinew
