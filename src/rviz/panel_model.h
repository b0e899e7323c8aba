#pragma once

#include <sinew/ActuatorState.h>
#include <sinew/ControllerState.h>

#include <array>
#include <string>
#include <vector>

namespace sinew {

/// The newest message of a topic.
template <typename Message>
struct Heard {
  boost::shared_ptr<const Message> message;  ///< null before the first
  double age = 0;                            ///< s since it came, by a steady clock
};

constexpr double kStaleAfter = 0.5;  ///< s without a message after which the last one no longer tells the present

enum class Tone { kPlain, kGood, kCaution, kBad, kStale };

struct PanelText {
  std::string text;
  Tone tone = Tone::kPlain;
};

/// What the panel can ask for, in the order of its buttons.
enum class Verb { kInit, kRecover, kHalt, kEnable, kDisable };

constexpr std::size_t kVerbs = 5;

/// The service (std_srvs/Trigger) behind a button, relative to the robot's namespace.
constexpr const char* serviceOf(Verb verb) {
  constexpr const char* kServices[kVerbs] = {"hardware_driver/init", "hardware_driver/recover", "hardware_driver/halt",
                                             "inverse_model/enable", "inverse_model/disable"};
  return kServices[static_cast<std::size_t>(verb)];
}

/// One actuator. Numbers are in the unit of the texts: mm, N, kPa or ml.
struct ActuatorRow {
  std::string name;
  Tone tone = Tone::kPlain;          ///< kBad at fault, kCaution when not read, kStale
  double low = 0, high = 0;          ///< the driver's own range; equal when it is not known
  double applied = 0, measured = 0;  ///< not finite when not known
  std::string range, applied_text, measured_text, effort, temperature;
  bool zero_valid = false;
  std::string faults;  ///< in words, empty when healthy
};

/// All that the panel shows.
struct PanelView {
  PanelText driver, driver_reason;          ///< state in one word; why
  PanelText controller, controller_reason;  ///< likewise
  PanelText cycle;                          ///< ms that cycles take and may take
  PanelText counters;                       ///< what went wrong since the start
  PanelText stop;                           ///< what the emergency stop says of itself
  std::array<bool, kVerbs> possible{};      ///< by Verb: whether its button does anything now
  std::vector<ActuatorRow> actuators;
};

/// What is to be seen of the last messages, given their age and whether the panel's own emergency stop is pressed.
/// Nothing that is stale is shown as the present, and nothing but the emergency stop may be asked for on its grounds.
PanelView calcPanelView(const Heard<ActuatorState>& driver, const Heard<ControllerState>& controller,
                        bool stop_pressed);

}  // namespace sinew
