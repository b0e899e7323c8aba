#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/bus_group.h"
#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/can_port.h"
#include "sinew/hardware/hardware_description.h"

namespace sinew {

/// How lines are opened. Each returns nothing, and says why in `why`, when it cannot.
struct LineOpener {
  std::function<std::shared_ptr<ByteStream>(const BusDescription& bus, std::string& why)> serial;
  std::function<std::shared_ptr<CanPort>(const BusDescription& bus, std::string& why)> can;
};

/// The actuators of one device on a CAN bus.
struct CanDeviceGroup {
  std::vector<int> actuators;  ///< indices in the hardware description
  std::vector<int> places;     ///< the numbers that they have on the bus
};
/// The actuators on bus number `bus` by their devices.
std::vector<CanDeviceGroup> groupByDevice(const HardwareDescription& hardware, int bus);

/// The driver's side of all devices of a robot. Throws ConfigError where bus and devices do not fit.
std::unique_ptr<BusGroup> makeBusGroup(const HardwareDescription& hardware, const LineOpener& opener);

}  // namespace sinew
