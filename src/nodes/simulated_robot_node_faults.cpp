#include "simulated_robot_node_faults.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace sinew {
namespace {

FaultDesk::Answer refuse(const std::string& fault, double value, const std::string& expected) {
  std::ostringstream text;
  text << fault << " " << value << " is refused: " << expected;
  return {false, text.str()};
}

FaultDesk::Answer confirm(const std::string& fault, double value, const std::string& target) {
  std::ostringstream text;
  text << fault << " " << value << " on " << target;
  return {true, text.str()};
}

}  // namespace

FaultDesk::FaultDesk(SimulatedServoBus& bus, std::vector<std::string> actuators, const LineFaults& line,
                     std::function<void(double)> disconnect)
    : bus_(bus), actuators_(std::move(actuators)), line_(line), disconnect_(std::move(disconnect)) {
  bus_.setLineFaults(line_);
}

FaultDesk::Answer FaultDesk::inject(const std::string& fault, const std::string& actuator, double value) {
  if (!std::isfinite(value)) return refuse(fault, value, "the value must be finite");
  Answer answer{false,
                "unknown fault '" + fault +
                    "': it is one of corrupt, drop, delay, freeze, overheat, supply_dip, disconnect, power_cycle"};
  if (fault == "corrupt" || fault == "drop" || fault == "delay") answer = injectInLine(fault, value);
  if (fault == "freeze" || fault == "overheat" || fault == "power_cycle") {
    answer = injectInServos(fault, actuator, value);
  }
  if (fault == "supply_dip" || fault == "disconnect") answer = injectInSupply(fault, value);
  if (answer.success) ++counts_[fault];
  return answer;
}

FaultDesk::Answer FaultDesk::injectInLine(const std::string& fault, double value) {
  LineFaults line = line_;
  (fault == "corrupt" ? line.corrupt : fault == "drop" ? line.drop : line.delay) = value;
  if (value < 0 || line.corrupt + line.drop + line.delay > 1) {
    return refuse(fault, value, "probabilities are 0 or more, and corrupt, drop and delay together at most 1");
  }
  line_ = line;
  ++line_.seed;  // another sequence than the one before
  bus_.setLineFaults(line_);
  return confirm(fault, value, "the line");
}

FaultDesk::Answer FaultDesk::injectInServos(const std::string& fault, const std::string& actuator, double value) {
  if (!actuator.empty() && std::find(actuators_.begin(), actuators_.end(), actuator) == actuators_.end()) {
    return refuse(fault, value, "there is no actuator '" + actuator + "'");
  }
  for (int servo = 0; servo < bus_.size(); ++servo) {
    if (!actuator.empty() && actuators_[static_cast<size_t>(servo)] != actuator) continue;
    if (fault == "freeze") bus_.setFrozen(servo, value != 0);
    if (fault == "overheat") bus_.setTemperature(servo, value);
    if (fault == "power_cycle") bus_.powerCycle(servo);
  }
  return confirm(fault, value, actuator.empty() ? "every servo" : actuator);
}

FaultDesk::Answer FaultDesk::injectInSupply(const std::string& fault, double value) {
  if (fault == "supply_dip") {
    if (value < 0 || value > 16) return refuse(fault, value, "a supply is 0 to 16 V");
    bus_.setSupplyVoltage(value);
    return confirm(fault, value, "the supply");
  }
  if (value <= 0 || value > 3600) return refuse(fault, value, "a line is away for more than 0 and at most 3600 s");
  disconnect_(value);
  return confirm(fault, value, "the line");
}

}  // namespace sinew
