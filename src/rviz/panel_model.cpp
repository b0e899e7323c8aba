#include "panel_model.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>

#include "sinew/hardware/actuator_fault.h"
#include "sinew/hardware/actuator_reading.h"
#include "sinew/hardware/driver_state.h"

namespace sinew {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr int kFaultBits = 32;
const char* const kNothing = "–";

struct Unit {
  const char* name;
  double per_si;  // shown number of one SI unit
  int decimals;
};

constexpr Unit kTension{"N", 1, 1};
constexpr Unit kPressure{"kPa", 1e-3, 1};

Unit unitOf(std::uint8_t mode) {
  switch (static_cast<Quantity>(mode)) {
    case Quantity::kDisplacement:
      return {"mm", 1e3, 2};
    case Quantity::kTension:
      return kTension;
    case Quantity::kPressure:
      return kPressure;
    case Quantity::kVolume:
      return {"ml", 1e6, 2};
  }
  return {"?", 1, 3};
}

Unit effortUnitOf(std::uint8_t mode) {
  const Quantity quantity = static_cast<Quantity>(mode);
  return quantity == Quantity::kPressure || quantity == Quantity::kVolume ? kPressure : kTension;
}

std::string formatNumber(double value, int decimals, const char* unit) {
  if (!std::isfinite(value)) return kNothing;
  char text[64];
  std::snprintf(text, sizeof text, "%.*f %s", decimals, value, unit);
  return text;
}

std::string formatQuantity(double si, const Unit& unit) {
  return formatNumber(si * unit.per_si, unit.decimals, unit.name);
}

std::string formatMilliseconds(double seconds) {
  return formatNumber(1e3 * seconds, 1, "ms");
}

std::string upperCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

// Messages of a recording, or of another version, may have fewer entries than names.
template <typename Values>
double valueAt(const Values& values, std::size_t i, double otherwise = kUnknown) {
  return i < values.size() ? static_cast<double>(values[i]) : otherwise;
}

template <typename Message>
bool isFresh(const Heard<Message>& heard) {
  return heard.message && heard.age <= kStaleAfter;
}

// --- States ---

Tone toneOf(DriverState state) {
  switch (state) {
    case DriverState::kOff:
      return Tone::kPlain;
    case DriverState::kReady:
    case DriverState::kActive:
      return Tone::kGood;
    case DriverState::kInitialising:
    case DriverState::kHolding:
    case DriverState::kSafe:
      return Tone::kCaution;
    case DriverState::kFault:
      break;
  }
  return Tone::kBad;
}

DriverState stateOf(const ActuatorState& message) {
  return static_cast<DriverState>(std::min<int>(message.driver_state, kDriverStates - 1));
}

PanelText controllerText(std::uint8_t status) {
  switch (status) {
    case ControllerState::DISABLED:
      return {"DISABLED", Tone::kPlain};
    case ControllerState::TRACKING:
      return {"TRACKING", Tone::kGood};
    case ControllerState::DEGRADED:
      return {"DEGRADED", Tone::kCaution};
    case ControllerState::HELD:
      return {"HELD", Tone::kBad};
    default:
      return {"UNKNOWN", Tone::kBad};
  }
}

// What takes the place of a state that nobody tells, and of its reason.
template <typename Message>
void describeSilence(const Heard<Message>& heard, const std::string& last, PanelText& state, PanelText& reason) {
  if (!heard.message) {
    state = {"NO DATA", Tone::kStale};
    reason = {"nothing heard yet", Tone::kStale};
    return;
  }
  state = {"STALE", Tone::kStale};
  reason = {"silent for " + formatNumber(heard.age, 1, "s") + "; last: " + last, Tone::kStale};
}

void showDriver(const Heard<ActuatorState>& driver, PanelView& view) {
  const std::string state = driver.message ? name(stateOf(*driver.message)) : "";
  if (!isFresh(driver)) return describeSilence(driver, state, view.driver, view.driver_reason);
  view.driver = {upperCase(state), toneOf(stateOf(*driver.message))};
  view.driver_reason = {driver.message->reason, Tone::kPlain};
}

void showController(const Heard<ControllerState>& controller, PanelView& view) {
  const PanelText state = controller.message ? controllerText(controller.message->status) : PanelText{};
  if (!isFresh(controller)) return describeSilence(controller, state.text, view.controller, view.controller_reason);
  view.controller = state;
  view.controller_reason = {controller.message->reason, Tone::kPlain};
}

// --- Time ---

PanelText cycleText(const Heard<ControllerState>& controller) {
  if (!controller.message) return {kNothing, Tone::kStale};
  const ControllerState& message = *controller.message;
  const auto cycle = std::find_if(message.stages.begin(), message.stages.end(),
                                  [](const StageTime& stage) { return stage.stage == "cycle"; });
  if (cycle == message.stages.end()) return {kNothing, Tone::kPlain};
  const bool late = message.period > 0 && cycle->maximum > message.period;
  const std::string text = formatMilliseconds(cycle->median) + " median, " + formatMilliseconds(cycle->maximum) +
                           " worst of " + formatMilliseconds(message.period);
  return {text, !isFresh(controller) ? Tone::kStale : late ? Tone::kCaution : Tone::kPlain};
}

std::uint64_t countRefused(const ActuatorState& message) {
  return message.rejected_session + message.rejected_sequence + message.rejected_malformed +
         message.rejected_not_finite + message.rejected_state;
}

PanelText countersText(const Heard<ActuatorState>& driver, const Heard<ControllerState>& controller) {
  const std::string misses = controller.message ? std::to_string(controller.message->deadline_misses) : kNothing;
  const std::string refused = driver.message ? std::to_string(countRefused(*driver.message)) : kNothing;
  const int overload = controller.message ? controller.message->overload_level : 0;
  std::string text = misses + " cycles missed, " + refused + " commands refused";
  if (overload > 0) text += ", overload " + std::to_string(overload);
  if (!isFresh(driver) || !isFresh(controller)) return {text, Tone::kStale};
  return {text, overload > 0 ? Tone::kCaution : Tone::kPlain};
}

// --- What can be asked for ---

// `init` homes every actuator anew, which `recover` does not: it is left for where the zeros are doubtful anyway.
bool isPossible(Verb verb, const ActuatorState& message) {
  const DriverState state = stateOf(message);
  const auto leadsOn = [state](DriverEvent event) { return nextState(state, event) != state; };
  switch (verb) {
    case Verb::kInit:
      return isSafe(state) && leadsOn(DriverEvent::kInit) && !message.emergency_stop;
    case Verb::kRecover:
      return leadsOn(DriverEvent::kRecover) && !message.emergency_stop;
    case Verb::kHalt:
      return leadsOn(DriverEvent::kHalt);
    default:
      return false;
  }
}

void showPossible(const Heard<ActuatorState>& driver, const Heard<ControllerState>& controller, PanelView& view) {
  const auto possible = [&view](Verb verb) -> bool& { return view.possible[static_cast<std::size_t>(verb)]; };
  if (isFresh(driver))
    for (const Verb verb : {Verb::kInit, Verb::kRecover, Verb::kHalt})
      possible(verb) = isPossible(verb, *driver.message);
  if (!isFresh(controller)) return;
  const bool enabled = controller.message->status != ControllerState::DISABLED;
  possible(Verb::kEnable) = !enabled && isFresh(driver) && takesCommands(stateOf(*driver.message));
  possible(Verb::kDisable) = enabled;
}

PanelText stopText(const Heard<ActuatorState>& driver, bool pressed) {
  const bool confirmed = isFresh(driver) && driver.message->emergency_stop;
  if (!pressed) return {confirmed ? "EMERGENCY STOP\npressed elsewhere" : "EMERGENCY STOP", Tone::kBad};
  return {confirmed ? "STOPPED\npress to let go" : "STOP SENT\nnot confirmed by the driver", Tone::kBad};
}

// --- Actuators ---

std::string describeFaults(std::uint32_t faults) {
  std::string words;
  for (int bit = 0; bit < kFaultBits; ++bit) {
    const std::uint32_t fault = faults & (1u << bit);
    if (fault == 0) continue;
    const std::string word = describeFault(fault);
    if (words.find(word) == std::string::npos) words += (words.empty() ? "" : ", ") + word;
  }
  return words;
}

// Servos tell at least room temperature: 0 means that the device does not tell.
std::string formatTemperature(double celsius) {
  return celsius == 0 ? kNothing : formatNumber(celsius, 0, "°C");
}

ActuatorRow makeRow(const ActuatorState& message, std::size_t i, bool fresh) {
  const std::uint8_t mode = i < message.mode.size() ? message.mode[i] : 0;
  const Unit unit = unitOf(mode);
  const bool valid = valueAt(message.measured_valid, i, 0) != 0;
  ActuatorRow row;
  row.name = message.name[i];
  row.low = valueAt(message.limit_min, i, 0) * unit.per_si;
  row.high = valueAt(message.limit_max, i, 0) * unit.per_si;
  row.applied = valueAt(message.applied, i) * unit.per_si;
  row.measured = valueAt(message.measured, i) * unit.per_si;
  const auto format = [&unit](double shown) { return formatNumber(shown, unit.decimals, unit.name); };
  if (row.high > row.low) row.range = format(row.low) + " to " + format(row.high);
  row.applied_text = format(row.applied);
  row.measured_text = format(row.measured);
  row.effort = formatQuantity(valueAt(message.effort, i), effortUnitOf(mode));
  row.temperature = formatTemperature(valueAt(message.temperature, i));
  row.zero_valid = valueAt(message.zero_valid, i, 0) != 0;
  row.faults = i < message.fault.size() ? describeFaults(message.fault[i]) : "";
  row.tone = !fresh ? Tone::kStale : !row.faults.empty() ? Tone::kBad : valid ? Tone::kPlain : Tone::kCaution;
  return row;
}

}  // namespace

PanelView calcPanelView(const Heard<ActuatorState>& driver, const Heard<ControllerState>& controller,
                        bool stop_pressed) {
  PanelView view;
  showDriver(driver, view);
  showController(controller, view);
  showPossible(driver, controller, view);
  view.cycle = cycleText(controller);
  view.counters = countersText(driver, controller);
  view.stop = stopText(driver, stop_pressed);
  if (!driver.message) return view;
  for (std::size_t i = 0; i < driver.message->name.size(); ++i)
    view.actuators.push_back(makeRow(*driver.message, i, isFresh(driver)));
  return view;
}

}  // namespace sinew
