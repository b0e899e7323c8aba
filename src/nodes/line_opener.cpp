#include "line_opener.h"

#include <ros/param.h>
#include <ros/time.h>

#include <string>

#include "sinew/hardware/port_opener.h"
#include "sinew/hardware/serial_port.h"

namespace sinew {
namespace {

bool isSimulatedTime() {
  bool simulated = ros::Time::isSimTime();
  if (!simulated) ros::param::get("/use_sim_time", simulated);
  return simulated;
}

bool isForbidden(const BusDescription& bus, bool simulated, std::string& why) {
  const bool virtual_interface = bus.isCanInterface() && bus.port.compare(0, 4, "vcan") == 0;
  const bool real = !simulated && !bus.simulated && !virtual_interface && !isPseudoTerminal(bus.port);
  if (!real || !isSimulatedTime()) return false;
  why = bus.port + " is a real port, which stays closed while /use_sim_time is true";
  return true;
}

}  // namespace

LineOpener makeLineOpener(bool simulated) {
  const LineOpener ports = makePortOpener();
  LineOpener opener;
  opener.serial = [simulated, open = ports.serial](const BusDescription& bus, std::string& why) {
    return isForbidden(bus, simulated, why) ? nullptr : open(bus, why);
  };
  opener.can = [simulated, open = ports.can](const BusDescription& bus, std::string& why) {
    return isForbidden(bus, simulated, why) ? nullptr : open(bus, why);
  };
  return opener;
}

}  // namespace sinew
