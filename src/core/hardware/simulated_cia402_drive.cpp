#include "sinew/hardware/simulated_cia402_drive.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

using Mapping = SimulatedObjectDictionary::Mapping;

constexpr double kTwoPi = 6.283185307179586;
constexpr double kNominalVoltage = 24;
constexpr std::int64_t kMax32 = 0xFFFFFFFF, kMaxI32 = 0x7FFFFFFF;
constexpr std::int64_t kPdoOff = 0x80000000;

constexpr std::uint16_t kRpdoParameters = 0x1400, kRpdoMapping = 0x1600;
constexpr std::uint16_t kTpdoParameters = 0x1800, kTpdoMapping = 0x1A00;

// Modes of operation.
constexpr int kProfilePosition = 1, kHomingMode = 6, kCyclicPosition = 8;

// SDO abort codes that the drive's own rules lead to.
constexpr std::uint32_t kUnsupportedAccess = 0x06010000, kNotMappable = 0x06040041, kPdoTooLong = 0x06040042;
constexpr std::uint32_t kOutOfRange = 0x06090030, kWrongState = 0x08000022;

// Bits of the error register.
constexpr std::uint8_t kGeneric = 0x01, kVoltage = 0x04, kTemperature = 0x08, kCommunication = 0x10, kMotion = 0x20;

bool isIn(std::uint16_t index, std::uint16_t first) {
  return index >= first && index < first + 4;
}

double clampAbs(double x, double limit) {
  return std::max(-limit, std::min(limit, x));
}

void store(std::int64_t value, std::size_t at, std::size_t size, CanFrame& frame) {
  for (std::size_t i = 0; i < size; ++i)
    frame.data[at + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
}

std::uint16_t offset(std::uint16_t first, std::size_t n) {
  return static_cast<std::uint16_t>(first + n);
}

}  // namespace

SimulatedCia402Drive::SimulatedCia402Drive(std::uint8_t node, const Parameters& parameters)
    : parameters_(parameters), node_(node), server_(node, dictionary_) {
  addObjects();
  addPdos();
  dictionary_.setHooks([this](std::uint16_t i, std::uint8_t s, std::int64_t v) { return check(i, s, v); },
                       [this](std::uint16_t i, std::uint8_t s) { written(i, s); });
  boot();
}

// --- Object dictionary ---

void SimulatedCia402Drive::addNumber(std::uint16_t index, std::uint8_t subindex, std::uint8_t size, bool is_signed,
                                     bool writable, Mapping mapping, std::int64_t initial, std::int64_t min,
                                     std::int64_t max) {
  dictionary_.add({index, subindex, size, is_signed, writable, mapping, initial, min, max, initial});
}

void SimulatedCia402Drive::addObjects() {
  const auto readOnly = [&](std::uint16_t index, std::uint8_t sub, std::uint8_t size, bool is_signed, std::int64_t v,
                            Mapping mapping = Mapping::kNone) {
    addNumber(index, sub, size, is_signed, false, mapping, v, 0, 0);
  };
  const auto writable = [&](std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::int64_t v, std::int64_t min,
                            std::int64_t max, Mapping mapping = Mapping::kNone) {
    addNumber(index, sub, size, min < 0, true, mapping, v, min, max);
  };
  readOnly(0x1000, 0, 4, false, parameters_.device_type);
  readOnly(0x1001, 0, 1, false, 0, Mapping::kTransmit);
  dictionary_.addText(0x1008, "simulated drive of profile 402", 0);
  readOnly(0x1016, 0, 1, false, 1);
  writable(0x1016, 1, 4, 0, 0, kMax32);
  writable(0x1017, 0, 2, 0, 0, 0xFFFF);
  readOnly(0x1018, 0, 1, false, 4);
  readOnly(0x1018, 1, 4, false, parameters_.vendor);
  readOnly(0x1018, 2, 4, false, parameters_.product);
  readOnly(0x1018, 3, 4, false, 0x00010000);
  readOnly(0x1018, 4, 4, false, node_);
  readOnly(0x1029, 0, 1, false, 1);
  writable(0x1029, 1, 1, 0, 0, 2);
  dictionary_.addText(0x2010, "", 32);  // a name that the user gives
  const auto rated_current = std::lround(1e3 * parameters_.rated_current);
  const auto peak = std::lround(1e3 * parameters_.peak);
  readOnly(0x3001, 0, 1, false, 2);
  writable(0x3001, 1, 4, rated_current, 0, 100000);
  writable(0x3001, 2, 4, std::lround(parameters_.peak * static_cast<double>(rated_current)), 0, 100000,
           Mapping::kReceive);
  readOnly(0x30D1, 0, 1, false, 2);
  readOnly(0x30D1, 2, 4, true, 0, Mapping::kTransmit);
  writable(0x6007, 0, 2, 1, -0x8000, 3);
  readOnly(0x603F, 0, 2, false, 0, Mapping::kTransmit);
  writable(0x6040, 0, 2, 0, 0, 0xFFFF, Mapping::kReceive);
  readOnly(0x6041, 0, 2, false, 0, Mapping::kTransmit);
  writable(0x605A, 0, 2, 2, -0x8000, 0x7FFF);
  writable(0x6060, 0, 1, kProfilePosition, -0x80, 0x7F, Mapping::kReceive);
  readOnly(0x6061, 0, 1, true, kProfilePosition, Mapping::kTransmit);
  readOnly(0x6062, 0, 4, true, 0, Mapping::kTransmit);
  readOnly(0x6064, 0, 4, true, 0, Mapping::kTransmit);
  writable(0x6065, 0, 4, 2000, 0, kMax32, Mapping::kReceive);
  writable(0x6066, 0, 2, 0, 0, 0xFFFF, Mapping::kReceive);
  writable(0x6072, 0, 2, peak, 0, 0xFFFF, Mapping::kReceive);
  writable(0x6073, 0, 2, peak, 0, 0xFFFF, Mapping::kReceive);
  writable(0x6075, 0, 4, rated_current, 0, kMax32);
  writable(0x6076, 0, 4, std::lround(1e3 * parameters_.rated_torque), 0, kMax32);
  readOnly(0x6077, 0, 2, true, 0, Mapping::kTransmit);
  readOnly(0x6078, 0, 2, true, 0, Mapping::kTransmit);
  writable(0x607A, 0, 4, 0, -kMaxI32 - 1, kMaxI32, Mapping::kReceive);
  writable(0x607C, 0, 4, 0, -kMaxI32 - 1, kMaxI32);
  writable(0x607F, 0, 4, 50000, 1, 50000, Mapping::kReceive);
  writable(0x6080, 0, 4, 50000, 1, 50000, Mapping::kReceive);
  writable(0x6085, 0, 4, 10000, 1, kMax32, Mapping::kReceive);
  writable(0x6098, 0, 1, 0, -0x80, 0x7F, Mapping::kReceive);
  readOnly(0x6099, 0, 1, false, 2);
  writable(0x6099, 1, 4, 100, 1, 50000, Mapping::kReceive);
  writable(0x6099, 2, 4, 10, 1, 50000, Mapping::kReceive);
  writable(0x609A, 0, 4, 1000, 1, kMax32, Mapping::kReceive);
  readOnly(0x60C2, 0, 1, false, 2);
  writable(0x60C2, 1, 1, 1, 0, 100);
  writable(0x60C2, 2, 1, -3, -6, -1);
}

void SimulatedCia402Drive::addPdos() {
  for (std::size_t n = 0; n < kPdos; ++n) {
    const auto step = static_cast<std::int64_t>(0x100 * n);
    for (const bool transmit : {false, true}) {
      const std::uint16_t parameters = offset(transmit ? kTpdoParameters : kRpdoParameters, n);
      const std::uint16_t mapping = offset(transmit ? kTpdoMapping : kRpdoMapping, n);
      const std::int64_t id = (transmit ? 0x40000180 : 0x200) + step + node_;
      addNumber(parameters, 0, 1, false, false, Mapping::kNone, 2, 0, 0);
      addNumber(parameters, 1, 4, false, true, Mapping::kNone, n == 0 ? id : id | kPdoOff, 0, kMax32);
      addNumber(parameters, 2, 1, false, true, Mapping::kNone, 255, 0, 255);
      addNumber(mapping, 0, 1, false, true, Mapping::kNone, 1, 0, 8);
      for (std::uint8_t i = 1; i <= 8; ++i) {
        const std::int64_t initial = i > 1 ? 0 : transmit ? 0x60410010 : 0x60400010;
        addNumber(mapping, i, 4, false, true, Mapping::kNone, initial, 0, kMax32);
      }
    }
  }
}

std::uint32_t SimulatedCia402Drive::check(std::uint16_t index, std::uint8_t subindex, std::int64_t value) const {
  if (isIn(index, kRpdoParameters) || isIn(index, kTpdoParameters)) return checkPdo(index, subindex, value);
  if (isIn(index, kRpdoMapping) || isIn(index, kTpdoMapping)) return checkMapping(index, subindex, value);
  switch (index) {
    case 0x6060:
      return value == kProfilePosition || value == kHomingMode || value == kCyclicPosition ? 0 : kOutOfRange;
    case 0x6098:
      return value == 17 || value == 18 || value == 35 || value == 37 ? 0 : kOutOfRange;
    case 0x605A:
      return value == 0 || value == 2 || value == 6 ? 0 : kOutOfRange;
    case 0x6007:
      return value >= 0 ? 0 : kOutOfRange;
    default:
      return 0;
  }
}

// Identifier and transmission type of a PDO change only while it is off.
std::uint32_t SimulatedCia402Drive::checkPdo(std::uint16_t index, std::uint8_t subindex, std::int64_t value) const {
  if (subindex == 2) {
    if (value > 240 && value < 254) return kOutOfRange;
    return pdoValid(index) && value != dictionary_.get(index, 2) ? kWrongState : 0;
  }
  constexpr std::int64_t kIdentifier = 0x1FFFFFFF;
  const bool on = (value & kPdoOff) == 0;
  const bool same = (value & kIdentifier) == (dictionary_.get(index, 1) & kIdentifier);
  if (on && pdoValid(index) && !same) return kOutOfRange;
  const std::int64_t id = value & kIdentifier;
  return on && (id < 0x181 || id > 0x57F) ? kOutOfRange : 0;
}

// A mapping is emptied (while its PDO is off and nothing operational), filled entry by entry, and counted.
std::uint32_t SimulatedCia402Drive::checkMapping(std::uint16_t index, std::uint8_t subindex, std::int64_t value) const {
  const bool transmit = isIn(index, kTpdoMapping);
  if (pdoValid(static_cast<std::uint16_t>(index - 0x200)) || nmt_ == Nmt::kOperational) return kWrongState;
  if (subindex == 0) {
    std::int64_t bits = 0;
    for (std::uint8_t i = 1; i <= static_cast<std::uint8_t>(value); ++i) {
      const std::int64_t entry = dictionary_.get(index, i);
      if (entry == 0) return kNotMappable;
      bits += entry & 0xFF;
    }
    return bits > 64 ? kPdoTooLong : 0;
  }
  if (dictionary_.get(index, 0) != 0) return kUnsupportedAccess;
  const auto* mapped = dictionary_.find(static_cast<std::uint16_t>(value >> 16), static_cast<std::uint8_t>(value >> 8));
  const Mapping wanted = transmit ? Mapping::kTransmit : Mapping::kReceive;
  const bool fits = mapped != nullptr && mapped->mapping == wanted && (value & 0xFF) == 8 * mapped->size;
  return fits ? 0 : kNotMappable;
}

void SimulatedCia402Drive::written(std::uint16_t index, std::uint8_t) {
  switch (index) {
    case 0x6040:
      return control(static_cast<std::uint16_t>(dictionary_.get(0x6040)));
    case 0x6060:
      dictionary_.set(0x6061, 0, dictionary_.get(0x6060));
      homing_ = Homing::kIdle;
      return enterOperation();
    case 0x607A:
      return retarget();
    case 0x1016:
      consumer_armed_ = false;
      return;
    case 0x1017:
      heartbeat_sent_ = false;
      return;
    default:
      return;
  }
}

// Power-up: everything at its defaults; an incremental encoder counts from here.
void SimulatedCia402Drive::boot() {
  dictionary_.reset(0x1000, 0xFFFF);
  server_.reset();
  nmt_ = Nmt::kPreOperational;
  boot_up_due_ = true;
  heartbeat_sent_ = consumer_armed_ = false;
  received_ = {};
  emergencies_.clear();
  state_ = State::kSwitchOnDisabled;
  controlword_ = 0;
  homing_ = Homing::kIdle;
  zero_ = parameters_.absolute_encoder ? 0 : angle_;
  demand_ = target_ = angle_;
  demand_speed_ = torque_ = following_time_ = time_left_ = 0;
  refresh();
}

// --- The bus ---

void SimulatedCia402Drive::take(const CanFrame& frame, Time now, std::vector<CanFrame>& out) {
  now_ = now;
  if (!powered_ || frozen_ || frame.extended || frame.remote) return;
  const std::int64_t consumer = dictionary_.get(0x1016, 1);
  if (frame.id == 0x000 && frame.size == 2) {
    if (frame.data[1] == 0 || frame.data[1] == node_) takeNmt(frame.data[0]);
  } else if (frame.id == 0x080 && nmt_ == Nmt::kOperational) {
    takeSync(out);
  } else if (frame.id == 0x600u + node_ && nmt_ != Nmt::kStopped) {
    refresh();
    CanFrame reply;
    if (server_.serve(frame, reply)) out.push_back(reply);
  } else if (frame.id == 0x700u + (consumer >> 16 & 0x7F) && frame.size == 1) {
    consumed_at_ = now;
    consumer_armed_ = (consumer & 0xFFFF) != 0;
  } else if (nmt_ == Nmt::kOperational) {
    takePdo(frame);
  }
}

void SimulatedCia402Drive::takeNmt(std::uint8_t command) {
  received_ = {};
  switch (command) {
    case 0x01:
      nmt_ = Nmt::kOperational;
      last_event_ = {};
      break;
    case 0x02:
      nmt_ = Nmt::kStopped;
      stopConnection();
      break;
    case 0x80:
      nmt_ = Nmt::kPreOperational;
      break;
    case 0x81:
      state_ = State::kSwitchOnDisabled;
      dictionary_.reset(0x2000, 0xFFFF);
      controlword_ = 0;
      homing_ = Homing::kIdle;
      [[fallthrough]];
    case 0x82:
      stopConnection();
      dictionary_.reset(0x1000, 0x1FFF);
      server_.reset();
      nmt_ = Nmt::kPreOperational;
      boot_up_due_ = true;
      heartbeat_sent_ = consumer_armed_ = false;
      break;
    default:
      break;
  }
}

bool SimulatedCia402Drive::pdoValid(std::uint16_t parameters) const {
  return (dictionary_.get(parameters, 1) & kPdoOff) == 0;
}

std::uint8_t SimulatedCia402Drive::mappedCount(std::uint16_t mapping) const {
  return static_cast<std::uint8_t>(dictionary_.get(mapping, 0));
}

std::size_t SimulatedCia402Drive::mappedBytes(std::uint16_t mapping) const {
  std::size_t bits = 0;
  for (std::uint8_t i = 1; i <= mappedCount(mapping); ++i)
    bits += static_cast<std::size_t>(dictionary_.get(mapping, i) & 0xFF);
  return bits / 8;
}

void SimulatedCia402Drive::takePdo(const CanFrame& frame) {
  for (std::size_t n = 0; n < kPdos; ++n) {
    const std::uint16_t parameters = offset(kRpdoParameters, n);
    if (!pdoValid(parameters) || (dictionary_.get(parameters, 1) & 0x7FF) != frame.id) continue;
    if (frame.size < mappedBytes(offset(kRpdoMapping, n))) {
      sendEmergency(0x8210, kGeneric | kCommunication);
      continue;
    }
    received_[n] = {true, frame};
    if (dictionary_.get(parameters, 2) > 240) applyPdo(n);
  }
}

void SimulatedCia402Drive::applyPdo(std::size_t n) {
  Received& received = received_[n];
  if (!received.pending) return;
  received.pending = false;
  const std::uint16_t mapping = offset(kRpdoMapping, n);
  std::size_t at = 0;
  for (std::uint8_t i = 1; i <= mappedCount(mapping); ++i) {
    const std::int64_t entry = dictionary_.get(mapping, i);
    const auto index = static_cast<std::uint16_t>(entry >> 16);
    const auto subindex = static_cast<std::uint8_t>(entry >> 8);
    const auto size = static_cast<std::size_t>(entry & 0xFF) / 8;
    std::vector<std::uint8_t> data(size);
    std::copy_n(received.frame.data.begin() + static_cast<std::ptrdiff_t>(at), size, data.begin());
    dictionary_.write(index, subindex, data);
    at += size;
  }
}

void SimulatedCia402Drive::takeSync(std::vector<CanFrame>& out) {
  for (std::size_t n = 0; n < kPdos; ++n) applyPdo(n);
  for (std::size_t n = 0; n < kPdos; ++n) {
    const std::int64_t type = dictionary_.get(offset(kTpdoParameters, n), 2);
    if (!pdoValid(offset(kTpdoParameters, n)) || type == 0 || type > 240) continue;
    if (++syncs_[n] < type) continue;
    syncs_[n] = 0;
    out.push_back(makeTpdo(n));
  }
}

CanFrame SimulatedCia402Drive::makeTpdo(std::size_t n) {
  refresh();
  const std::uint16_t mapping = offset(kTpdoMapping, n);
  CanFrame frame;
  frame.id = static_cast<std::uint32_t>(dictionary_.get(offset(kTpdoParameters, n), 1) & 0x7FF);
  for (std::uint8_t i = 1; i <= mappedCount(mapping); ++i) {
    const std::int64_t entry = dictionary_.get(mapping, i);
    const auto size = static_cast<std::size_t>(entry & 0xFF) / 8;
    store(dictionary_.get(static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8)), frame.size,
          size, frame);
    frame.size = static_cast<std::uint8_t>(frame.size + size);
  }
  return frame;
}

void SimulatedCia402Drive::update(Time now, std::vector<CanFrame>& out) {
  now_ = now;
  if (!powered_ || frozen_) return;
  if (boot_up_due_) {
    CanFrame frame;
    frame.id = 0x700u + node_;
    frame.size = 1;
    out.push_back(frame);
    boot_up_due_ = false;
  }
  updateConsumer(now);
  updateProducer(now, out);
  if (nmt_ == Nmt::kOperational) sendEvents(out);
  if (nmt_ != Nmt::kStopped) out.insert(out.end(), emergencies_.begin(), emergencies_.end());
  emergencies_.clear();
}

void SimulatedCia402Drive::sendEvents(std::vector<CanFrame>& out) {
  for (std::size_t n = 0; n < kPdos; ++n) {
    const std::uint16_t parameters = offset(kTpdoParameters, n);
    if (!pdoValid(parameters) || dictionary_.get(parameters, 2) < 254) continue;
    const CanFrame frame = makeTpdo(n);
    if (frame.size == last_event_[n].size && frame.data == last_event_[n].data) continue;
    last_event_[n] = frame;
    out.push_back(frame);
  }
}

// The driver's heartbeat is missed only once it has been heard.
void SimulatedCia402Drive::updateConsumer(Time now) {
  const double limit = 1e-3 * static_cast<double>(dictionary_.get(0x1016, 1) & 0xFFFF);
  if (!consumer_armed_ || seconds(now - consumed_at_) <= limit) return;
  consumer_armed_ = false;
  sendEmergency(0x8130, kGeneric | kCommunication);
  stopConnection();
  const std::int64_t behaviour = dictionary_.get(0x1029, 1);
  if (nmt_ == Nmt::kOperational && behaviour == 0) nmt_ = Nmt::kPreOperational;
  if (behaviour == 2) nmt_ = Nmt::kStopped;
}

void SimulatedCia402Drive::updateProducer(Time now, std::vector<CanFrame>& out) {
  const double period = 1e-3 * static_cast<double>(dictionary_.get(0x1017));
  if (period <= 0 || (heartbeat_sent_ && seconds(now - heartbeat_at_) < period)) return;
  CanFrame frame;
  frame.id = 0x700u + node_;
  frame.size = 1;
  frame.data[0] = static_cast<std::uint8_t>(nmt_);
  out.push_back(frame);
  heartbeat_sent_ = true;
  heartbeat_at_ = now;
}

// --- State machine of CiA 402 ---

std::uint16_t SimulatedCia402Drive::statusword() const {
  constexpr std::uint16_t kStates[] = {0x0040, 0x0021, 0x0023, 0x0027, 0x0007, 0x000F, 0x0008};
  unsigned word = kStates[static_cast<std::size_t>(state_)];
  if (voltage_ >= parameters_.min_voltage) word |= 1u << 4;
  if (nmt_ == Nmt::kOperational) word |= 1u << 9;
  if (at_limit_) word |= 1u << 11;
  const std::int64_t mode = dictionary_.get(0x6061);
  if (mode == kCyclicPosition && state_ == State::kOperationEnabled) {
    word |= 1u << 12;
    if (following_time_ > 0) word |= 1u << 13;
  }
  if (mode == kHomingMode && homing_ == Homing::kAttained) word |= 1u << 12;
  if (mode == kHomingMode && (homing_ == Homing::kAttained || homing_ == Homing::kIdle)) word |= 1u << 10;
  return static_cast<std::uint16_t>(word);
}

bool SimulatedCia402Drive::torqueOn() const {
  return state_ == State::kOperationEnabled || state_ == State::kQuickStop || state_ == State::kFaultReaction;
}

bool SimulatedCia402Drive::energised(int) const {
  return powered_ && torqueOn() && state_ != State::kQuickStop;
}

void SimulatedCia402Drive::control(std::uint16_t word) {
  const unsigned rising = word & ~static_cast<unsigned>(controlword_);
  controlword_ = word;
  if (state_ == State::kFault && (rising & 0x80) != 0) return resetFault();
  if ((word & 0x80) != 0) return;
  const bool disable_voltage = (word & 0x02) == 0, quick_stop = (word & 0x06) == 0x02;
  const bool shutdown = (word & 0x07) == 0x06, switch_on = (word & 0x0F) == 0x07, enable = (word & 0x0F) == 0x0F;
  const bool sound = voltage_ >= parameters_.min_voltage;
  switch (state_) {
    case State::kSwitchOnDisabled:
      if (shutdown) state_ = State::kReadyToSwitchOn;
      break;
    case State::kReadyToSwitchOn:
      if (disable_voltage || quick_stop) state_ = State::kSwitchOnDisabled;
      if ((switch_on || enable) && sound) state_ = State::kSwitchedOn;
      if (!enable || !sound) break;
      [[fallthrough]];
    case State::kSwitchedOn:
      if (disable_voltage || quick_stop) state_ = State::kSwitchOnDisabled;
      if (shutdown) state_ = State::kReadyToSwitchOn;
      if (enable) {
        state_ = State::kOperationEnabled;
        enterOperation();
      }
      break;
    case State::kOperationEnabled:
      if (disable_voltage) state_ = State::kSwitchOnDisabled;
      if (quick_stop) beginQuickStop();
      if (shutdown) state_ = State::kReadyToSwitchOn;
      if (switch_on) state_ = State::kSwitchedOn;
      if (enable && (rising & 0x10) != 0 && dictionary_.get(0x6061) == kHomingMode) startHoming();
      if ((word & 0x10) == 0 && homing_ != Homing::kAttained) homing_ = Homing::kIdle;
      break;
    case State::kQuickStop:
      if (disable_voltage) state_ = State::kSwitchOnDisabled;
      if (enable && dictionary_.get(0x605A) >= 5) {
        state_ = State::kOperationEnabled;
        enterOperation();
      }
      break;
    default:
      break;
  }
}

void SimulatedCia402Drive::enterOperation() {
  if (state_ != State::kOperationEnabled) return;
  demand_ = target_ = angle_;
  demand_speed_ = following_time_ = time_left_ = 0;
  homing_ = Homing::kIdle;
  retarget();
}

// The ramp begins at the speed that the shaft has.
void SimulatedCia402Drive::beginStop(State state) {
  state_ = state;
  demand_ = angle_;
  demand_speed_ = omega_;
}

void SimulatedCia402Drive::beginQuickStop() {
  beginStop(dictionary_.get(0x605A) == 0 ? State::kSwitchOnDisabled : State::kQuickStop);
}

// What object 6007 asks for when the driver is gone.
void SimulatedCia402Drive::stopConnection() {
  switch (dictionary_.get(0x6007)) {
    case 1:
      raiseFault(0x8130, kGeneric | kCommunication);
      break;
    case 2:
      if (torqueOn()) state_ = State::kSwitchOnDisabled;
      break;
    case 3:
      if (state_ == State::kOperationEnabled) beginQuickStop();
      break;
    default:
      break;
  }
}

void SimulatedCia402Drive::sendEmergency(std::uint16_t code, std::uint8_t error_register) {
  CanFrame frame;
  frame.id = 0x080u + node_;
  frame.size = 8;
  store(code, 0, 2, frame);
  frame.data[2] = error_register;
  emergencies_.push_back(frame);
}

void SimulatedCia402Drive::raiseFault(std::uint16_t code, std::uint8_t error_register) {
  if (state_ == State::kFault || state_ == State::kFaultReaction) return;
  beginStop(torqueOn() ? State::kFaultReaction : State::kFault);
  dictionary_.set(0x603F, 0, code);
  dictionary_.set(0x1001, 0, error_register);
  sendEmergency(code, error_register);
}

void SimulatedCia402Drive::resetFault() {
  state_ = State::kSwitchOnDisabled;
  dictionary_.set(0x603F, 0, 0);
  dictionary_.set(0x1001, 0, 0);
  sendEmergency(0, 0);
  updateAlarms();
}

void SimulatedCia402Drive::updateAlarms() {
  if (!powered_) return;
  if (temperature_ > parameters_.max_temperature) raiseFault(0x4210, kGeneric | kTemperature);
  if (voltage_ < parameters_.min_voltage) raiseFault(0x3220, kGeneric | kVoltage);
  if (voltage_ > parameters_.max_voltage) raiseFault(0x3210, kGeneric | kVoltage);
}

void SimulatedCia402Drive::setTemperature(double temperature) {
  temperature_ = temperature;
  updateAlarms();
}

void SimulatedCia402Drive::setSupplyVoltage(double voltage) {
  voltage_ = voltage;
  const bool powered = voltage >= parameters_.brown_out;
  if (powered && !powered_) boot();
  if (!powered) state_ = State::kSwitchOnDisabled;
  powered_ = powered;
  updateAlarms();
}

// --- Mechanics ---

std::int32_t SimulatedCia402Drive::toCounts(double angle) const {
  const double counts = (angle - zero_) * parameters_.counts_per_turn * parameters_.gear / kTwoPi;
  const std::int64_t wrapped = static_cast<std::int64_t>(std::llround(counts)) + kMaxI32 + 1;
  return static_cast<std::int32_t>((wrapped & kMax32) - kMaxI32 - 1);
}

double SimulatedCia402Drive::toAngle(double counts) const {
  return zero_ + counts * kTwoPi / (parameters_.counts_per_turn * parameters_.gear);
}

double SimulatedCia402Drive::omegaOf(std::int64_t rpm) const {
  return static_cast<double>(rpm) * kTwoPi / 60 / parameters_.gear;
}

void SimulatedCia402Drive::refresh() {
  const double rated_torque = parameters_.rated_torque * parameters_.gear;
  const auto effort = std::lround(1e3 * torque_ / rated_torque);
  dictionary_.set(0x6041, 0, statusword());
  dictionary_.set(0x6062, 0, toCounts(demand_));
  dictionary_.set(0x6064, 0, toCounts(angle_));
  dictionary_.set(0x6077, 0, effort);
  dictionary_.set(0x6078, 0, effort);
  dictionary_.set(0x30D1, 2, std::lround(1e3 * parameters_.rated_current * torque_ / rated_torque));
}

void SimulatedCia402Drive::retarget() {
  if (state_ != State::kOperationEnabled || dictionary_.get(0x6061) != kCyclicPosition) return;
  target_ = toAngle(static_cast<double>(dictionary_.get(0x607A)));
  time_left_ =
      static_cast<double>(dictionary_.get(0x60C2, 1)) * std::pow(10., static_cast<double>(dictionary_.get(0x60C2, 2)));
}

void SimulatedCia402Drive::step(double dt) {
  constexpr double kMaxStep = 1e-3;
  const int count = std::max(1, static_cast<int>(std::ceil(dt / kMaxStep - 1e-9)));
  for (int i = 0; i < count; ++i) substep(dt / count);
}

void SimulatedCia402Drive::substep(double dt) {
  if (frozen_) {
    omega_ = 0;
    return;
  }
  at_limit_ = false;
  torque_ = 0;
  const double max_speed = std::min({parameters_.no_load_speed * voltage_ / kNominalVoltage,
                                     omegaOf(dictionary_.get(0x6080)), omegaOf(dictionary_.get(0x607F))});
  if (powered_ && torqueOn()) {
    updateDemand(dt);
    const double wanted = (demand_ - angle_) * (1 - std::exp(-dt / parameters_.response_time)) / dt;
    const double needed = parameters_.damping * clampAbs(wanted, max_speed) - load_;
    torque_ = clampAbs(needed, torqueLimit());
    at_limit_ = torque_ != needed || std::abs(wanted) > max_speed;
  } else {
    demand_ = target_ = angle_;
    demand_speed_ = 0;
  }
  // What moves the shaft under torque has already overcome the friction of its gear.
  const double held = powered_ && torqueOn() ? 0 : clampAbs(load_, parameters_.friction);
  omega_ = clampAbs((torque_ + load_ - held) / parameters_.damping, parameters_.no_load_speed);
  angle_ += omega_ * dt;
  watchFollowing(dt);
}

double SimulatedCia402Drive::torqueLimit() const {
  const double rated = parameters_.rated_torque * parameters_.gear;
  const double per_mille = static_cast<double>(std::min(dictionary_.get(0x6072), dictionary_.get(0x6073))) * 1e-3;
  const double by_current = static_cast<double>(dictionary_.get(0x3001, 2)) * 1e-3 / parameters_.rated_current;
  return rated * std::min({per_mille, by_current, parameters_.peak});
}

void SimulatedCia402Drive::updateDemand(double dt) {
  if (state_ != State::kOperationEnabled) return updateStop(dt);
  if (dictionary_.get(0x6061) == kHomingMode) return updateHoming(dt);
  if (time_left_ <= 0) {
    demand_ = target_;
    demand_speed_ = 0;
    return;
  }
  demand_speed_ = (target_ - demand_) / time_left_;
  demand_ += demand_speed_ * std::min(dt, time_left_);
  time_left_ -= dt;
}

// Quick stop and fault reaction: along the ramp of object 6085.
void SimulatedCia402Drive::updateStop(double dt) {
  const double less = omegaOf(dictionary_.get(0x6085)) * dt;
  demand_speed_ -= clampAbs(demand_speed_, less);
  demand_ += demand_speed_ * dt;
  target_ = demand_;
  if (demand_speed_ != 0) return;
  if (state_ == State::kFaultReaction) state_ = State::kFault;
  if (state_ == State::kQuickStop && dictionary_.get(0x605A) < 5) state_ = State::kSwitchOnDisabled;
}

void SimulatedCia402Drive::startHoming() {
  const std::int64_t method = dictionary_.get(0x6098);
  homing_ = Homing::kToSwitch;
  if (method == 35 || method == 37) finishHoming();
}

void SimulatedCia402Drive::finishHoming() {
  demand_speed_ = 0;
  demand_ = target_ = angle_;
  const double offset_angle = toAngle(static_cast<double>(dictionary_.get(0x607C))) - zero_;
  zero_ = angle_ - offset_angle;
  homing_ = Homing::kAttained;
}

// Methods 17 and 18: to the lower or upper limit switch, then back until it opens.
void SimulatedCia402Drive::updateHoming(double dt) {
  if (homing_ == Homing::kIdle || homing_ == Homing::kAttained) {
    demand_speed_ = 0;
    return;
  }
  const bool down = dictionary_.get(0x6098) == 17;
  const bool closed = down ? angle_ <= parameters_.lower_switch : angle_ >= parameters_.upper_switch;
  if (homing_ == Homing::kOffSwitch && !closed) return finishHoming();
  if (closed) homing_ = Homing::kOffSwitch;
  const bool back = homing_ == Homing::kOffSwitch;
  const double speed = omegaOf(dictionary_.get(0x6099, back ? 2 : 1)) * (down == back ? 1 : -1);
  demand_speed_ += clampAbs(speed - demand_speed_, omegaOf(dictionary_.get(0x609A)) * dt);
  demand_ += demand_speed_ * dt;
}

void SimulatedCia402Drive::watchFollowing(double dt) {
  const std::int64_t window = dictionary_.get(0x6065);
  const std::int64_t off = std::llabs(static_cast<std::int64_t>(toCounts(demand_)) - toCounts(angle_));
  const bool outside = state_ == State::kOperationEnabled && window != kMax32 && off > window;
  following_time_ = outside ? following_time_ + dt : 0;
  if (outside && following_time_ > 1e-3 * static_cast<double>(dictionary_.get(0x6066)))
    raiseFault(0x8611, kGeneric | kMotion);
}

}  // namespace sinew
