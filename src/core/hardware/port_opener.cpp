#include "sinew/hardware/port_opener.h"

#include <memory>
#include <string>
#include <utility>

#include "sinew/hardware/serial_port.h"
#include "sinew/hardware/slcan_port.h"
#include "sinew/hardware/socket_can.h"

namespace sinew {
namespace {

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

LineOpener makePortOpener() {
  return {openSerial, openCan};
}

}  // namespace sinew
