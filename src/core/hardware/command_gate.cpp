#include "sinew/hardware/command_gate.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>

#include "sinew/common/config_error.h"

namespace sinew {

CommandReader::CommandReader(std::vector<std::string> names, std::vector<Quantity> quantities)
    : names_(std::move(names)), quantities_(std::move(quantities)) {
  if (names_.size() > kMaxActuators)
    throw ConfigError("number of actuators", std::to_string(names_.size()), "at most " + std::to_string(kMaxActuators));
}

Command CommandReader::read(std::uint32_t session, std::uint32_t sequence, std::uint8_t status,
                            const std::vector<std::string>& names, const std::vector<std::uint8_t>& modes,
                            const std::vector<double>& values, const std::vector<double>& efforts,
                            Time received) const {
  Command command;
  command.session = session;
  command.sequence = sequence;
  command.received = received;
  const std::size_t size = names_.size();
  if (names.size() != size || modes.size() != size || values.size() != size) return command;
  if (!efforts.empty() && efforts.size() != size) return command;
  if (status > static_cast<std::uint8_t>(CommandStatus::kHeld)) return command;
  command.status = static_cast<CommandStatus>(status);
  std::bitset<kMaxActuators> seen;
  bool finite = true;
  for (std::size_t i = 0; i < size; ++i) {
    const auto at = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), names[i]) - names_.begin());
    if (at == size || seen[at] || modes[i] != static_cast<std::uint8_t>(quantities_[at])) return command;
    seen[at] = true;
    finite = finite && std::isfinite(values[i]);
    command.value[at] = values[i];
    command.effort[at] = efforts.empty() ? std::numeric_limits<double>::quiet_NaN() : efforts[i];
  }
  command.defect = finite ? CommandVerdict::kAccepted : CommandVerdict::kNotFinite;
  return command;
}

CommandVerdict CommandGate::check(const Command& command) const {
  if (command.defect != CommandVerdict::kAccepted) return command.defect;
  if (!locked_) return CommandVerdict::kAccepted;
  if (command.session != session_) return CommandVerdict::kSession;
  const auto advance = static_cast<std::int32_t>(command.sequence - sequence_);  // rises also across the wrap
  return advance > 0 ? CommandVerdict::kAccepted : CommandVerdict::kSequence;
}

void CommandGate::accept(const Command& command) {
  locked_ = any_ = true;
  session_ = command.session;
  sequence_ = command.sequence;
  received_ = command.received;
  ++counters_.accepted;
}

void CommandGate::refuse(CommandVerdict reason) {
  switch (reason) {
    case CommandVerdict::kMalformed:
      ++counters_.malformed;
      break;
    case CommandVerdict::kNotFinite:
      ++counters_.not_finite;
      break;
    case CommandVerdict::kSession:
      ++counters_.session;
      break;
    case CommandVerdict::kSequence:
      ++counters_.sequence;
      break;
    case CommandVerdict::kState:
      ++counters_.state;
      break;
    case CommandVerdict::kAccepted:
      break;
  }
}

void CommandGate::release() {
  locked_ = false;
}

double CommandGate::age(Time now) const {
  return any_ ? seconds(now - received_) : -1;
}

}  // namespace sinew
