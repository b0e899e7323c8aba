#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "bus_session.h"
#include "bus_text.h"
#include "bus_verbs.h"
#include "zero_file.h"

namespace sinew {
namespace {

const char* describe(const ActuatorDescription& actuator) {
  if (actuator.quantity == Quantity::kPressure) return "a pressure, which needs no zero";
  switch (actuator.cable.homing.method) {
    case HomingMethod::kTension:
      return "reeled in until taut";
    case HomingMethod::kDevice:
      return "by the drive's own homing";
    case HomingMethod::kPresent:
      break;
  }
  return "where it was found";
}

bool movesAny(const HardwareDescription& hardware) {
  return std::any_of(hardware.actuators.begin(), hardware.actuators.end(), [](const ActuatorDescription& actuator) {
    return actuator.cable.homing.method != HomingMethod::kPresent;
  });
}

bool print(const HardwareDescription& hardware, const DriverReport& report) {
  const int width = calcWidth(hardware.names());
  bool any = false;
  for (std::size_t i = 0; i < hardware.actuators.size(); ++i) {
    const double counts = report.zero_counts[i];
    const bool keeps = std::isfinite(counts);
    any = any || keeps;
    const bool pressure = hardware.actuators[i].quantity == Quantity::kPressure;
    std::printf("  %-*s  %s", width, hardware.actuators[i].name.c_str(), describe(hardware.actuators[i]));
    if (keeps)
      std::printf("; counts %.0f at zero\n", counts);
    else
      std::printf(pressure ? "\n" : "; its count is not kept\n");
  }
  return any;
}

}  // namespace

int zero(const HardwareDescription& hardware, const ZeroOrder& order) {
  if (order.file.empty())
    throw WrongUse("neither ROS_HOME nor HOME is set: say by --file where zeros are to be written");
  std::string deed = "Every device is switched on and homed as the file says:\n";
  for (const ActuatorDescription& actuator : hardware.actuators)
    deed += "  " + actuator.name + ": " + describe(actuator) + "\n";
  deed += movesAny(hardware) ? "The robot moves." : "Nothing is to move.";
  if (!isAllowed(deed, order.yes)) return kDone;
  BusSession session(hardware);
  if (!session.setUp()) {
    std::printf("%s\n", session.whyNot().c_str());
    return kNotWell;
  }
  std::printf("homed:\n");
  if (!print(hardware, session.report())) {
    std::printf("no device counts in a way that could be written down: the driver homes again at its next start\n");
    return kDone;
  }
  ZeroFile(order.file).update(hardware.names(), session.report().zero_counts);
  if (!std::ifstream(order.file)) {
    std::printf("%s could not be written: does its folder exist?\n", order.file.c_str());
    return kNotWell;
  }
  std::printf("written to %s, valid until a device loses power\n", order.file.c_str());
  return kDone;
}

}  // namespace sinew
