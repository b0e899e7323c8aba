#include "line_opener.h"

#include <ros/param.h>
#include <ros/time.h>

#include <memory>
#include <string>
#include <utility>

#include "sinew/hardware/serial_port.h"
#include "sinew/hardware/slcan_port.h"
#include "sinew/hardware/socket_can.h"

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

std::shared_ptr<ByteStream> openSerial(const BusDescription& bus, std::string& why) {
  auto port = std::make_shared<SerialPort>();
  if (port->open(bus.port, bus.baud)) return port;
  why = port->error();
  return nullptr;
}

std::shared_ptr<CanPort> openInterface(const BusDescription& bus, std::string& why) {
  auto port = std::make_shared<SocketCan>();
  if (port->open(bus.port)) return port;
  why = port->error();
  return nullptr;
}

// A CAN interface of the kernel, or a serial adapter to a bus.
std::shared_ptr<CanPort> openCan(const BusDescription& bus, std::string& why) {
  if (bus.isCanInterface()) return openInterface(bus, why);
  std::shared_ptr<ByteStream> line = openSerial(bus, why);
  if (line == nullptr) return nullptr;
  auto port = std::make_shared<SlcanPort>();
  if (port->open(std::move(line), bus.bitrate)) return port;
  why = port->error();
  return nullptr;
}

}  // namespace

LineOpener makeLineOpener(bool simulated) {
  LineOpener opener;
  opener.serial = [simulated](const BusDescription& bus, std::string& why) {
    return isForbidden(bus, simulated, why) ? nullptr : openSerial(bus, why);
  };
  opener.can = [simulated](const BusDescription& bus, std::string& why) {
    return isForbidden(bus, simulated, why) ? nullptr : openCan(bus, why);
  };
  return opener;
}

}  // namespace sinew
