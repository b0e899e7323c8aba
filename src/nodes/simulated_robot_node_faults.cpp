#include "simulated_robot_node_faults.h"

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

FaultDesk::FaultDesk(SimulatedHardware& hardware, const LineFaults& line, std::function<void(int, double)> disconnect)
    : hardware_(hardware), line_(line), disconnect_(std::move(disconnect)) {
  hardware_.setLineFaults(line_);
}

FaultDesk::Answer FaultDesk::inject(const std::string& fault, const std::string& actuator, double value) {
  if (!std::isfinite(value)) return refuse(fault, value, "the value must be finite");
  Answer answer{false,
                "unknown fault '" + fault +
                    "': it is one of corrupt, drop, delay, duplicate, freeze, overheat, power_cycle, leak, snap, "
                    "supply_dip, disconnect"};
  if (fault == "corrupt" || fault == "drop" || fault == "delay" || fault == "duplicate") {
    answer = injectInLines(fault, value);
  }
  if (fault == "freeze" || fault == "overheat" || fault == "power_cycle" || fault == "leak" || fault == "snap") {
    answer = injectInActuators(fault, actuator, value);
  }
  if (fault == "supply_dip") answer = injectInSupply(value);
  if (fault == "disconnect") answer = takeLinesAway(actuator, value);
  if (answer.success) ++counts_[fault];
  return answer;
}

FaultDesk::Answer FaultDesk::injectInLines(const std::string& fault, double value) {
  LineFaults line = line_;
  (fault == "corrupt"     ? line.corrupt
   : fault == "drop"      ? line.drop
   : fault == "duplicate" ? line.duplicate
                          : line.delay) = value;
  if (value < 0 || line.corrupt + line.drop + line.delay + line.duplicate > 1) {
    return refuse(fault, value,
                  "probabilities are 0 or more, and corrupt, drop, delay and duplicate together at most 1");
  }
  line_ = line;
  ++line_.seed;  // another sequence than the one before
  hardware_.setLineFaults(line_);
  return confirm(fault, value, "every line");
}

FaultDesk::Answer FaultDesk::injectInActuators(const std::string& fault, const std::string& actuator, double value) {
  const int chosen = hardware_.findActuator(actuator);
  if (!actuator.empty() && chosen < 0) return refuse(fault, value, "there is no actuator '" + actuator + "'");
  if (fault == "leak" && value < 0) return refuse(fault, value, "a leak is 0 or more, 1/s");
  for (int i = 0; i < hardware_.size(); ++i)
    if (actuator.empty() || i == chosen) injectInActuator(fault, i, value);
  return confirm(fault, value, actuator.empty() ? "every actuator" : actuator);
}

void FaultDesk::injectInActuator(const std::string& fault, int actuator, double value) {
  if (fault == "freeze") hardware_.setFrozen(actuator, value != 0);
  if (fault == "overheat") hardware_.setTemperature(actuator, value);
  if (fault == "power_cycle") hardware_.powerCycle(actuator);
  if (fault == "leak") hardware_.setLeak(actuator, value);
  if (fault == "snap") hardware_.setSnapped(actuator, value != 0);
}

FaultDesk::Answer FaultDesk::injectInSupply(double value) {
  if (value < 0 || value > 60) return refuse("supply_dip", value, "a supply is 0 to 60 V");
  hardware_.setSupplyVoltage(value);
  return confirm("supply_dip", value, "the supply");
}

FaultDesk::Answer FaultDesk::takeLinesAway(const std::string& name, double value) {
  if (value <= 0 || value > 3600) {
    return refuse("disconnect", value, "a line is away for more than 0 and at most 3600 s");
  }
  const int chosen = hardware_.findBus(name);
  if (!name.empty() && chosen < 0) return refuse("disconnect", value, "there is no bus or actuator '" + name + "'");
  for (int bus = 0; bus < hardware_.buses(); ++bus)
    if (name.empty() || bus == chosen) disconnect_(bus, value);
  return confirm("disconnect", value, name.empty() ? "every line" : "the line of " + name);
}

}  // namespace sinew
