#include "line_opener.h"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/time.h>

#include <memory>
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

// An adapter that sits on bytes is slower than a cycle; nothing else tells so at the start.
void warnOfLatency(const BusDescription& bus, const ByteStream* line) {
  const auto* port = dynamic_cast<const SerialPort*>(line);
  if (port == nullptr || port->lowLatency() || isPseudoTerminal(bus.port)) return;
  ROS_WARN(
      "%s does not know low latency: FTDI adapters then wait 16 ms; see the udev rule in docs/hardware.md, and "
      "measure with `rosrun sinew bus latency`",
      bus.port.c_str());
}

}  // namespace

LineOpener makeLineOpener(bool simulated) {
  const LineOpener ports = makePortOpener();
  LineOpener opener;
  opener.serial = [simulated, open = ports.serial](const BusDescription& bus, std::string& why) {
    std::shared_ptr<ByteStream> line = isForbidden(bus, simulated, why) ? nullptr : open(bus, why);
    warnOfLatency(bus, line.get());
    return line;
  };
  opener.can = [simulated, open = ports.can](const BusDescription& bus, std::string& why) {
    return isForbidden(bus, simulated, why) ? nullptr : open(bus, why);
  };
  return opener;
}

}  // namespace sinew
