#include "line_opener.h"

#include <ros/param.h>
#include <ros/time.h>

#include <memory>
#include <string>

#include "sinew/hardware/serial_port.h"

namespace sinew {
namespace {

bool isSimulatedTime() {
  bool simulated = ros::Time::isSimTime();
  if (!simulated) ros::param::get("/use_sim_time", simulated);
  return simulated;
}

bool isForbidden(const BusDescription& bus, bool simulated, std::string& why) {
  const bool real = !simulated && !bus.simulated && !isPseudoTerminal(bus.port);
  if (!real || !isSimulatedTime()) return false;
  why = bus.port + " is a real port, which stays closed while /use_sim_time is true";
  return true;
}

std::shared_ptr<ByteStream> openSerial(const BusDescription& bus, std::string& why) {
  auto port = std::make_shared<SerialPort>();
  if (port->open(bus.port, bus.baud)) return port;
  why = port->error();
  return nullptr;
}

}  // namespace

LineOpener makeLineOpener(bool simulated) {
  LineOpener opener;
  opener.serial = [simulated](const BusDescription& bus, std::string& why) {
    return isForbidden(bus, simulated, why) ? nullptr : openSerial(bus, why);
  };
  return opener;
}

}  // namespace sinew
