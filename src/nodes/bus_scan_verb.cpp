#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "bus_session.h"
#include "bus_text.h"
#include "bus_verbs.h"
#include "sinew/hardware/dynamixel_packet.h"
#include "sinew/hardware/port_opener.h"
#include "sinew/hardware/pressure_message.h"
#include "sinew/hardware/serial_port.h"
#include "sinew/hardware/socket_can.h"

namespace sinew {
namespace {

constexpr int kServoBauds[] = {57600, 1000000, 2000000, 3000000, 4000000, 115200, 9600};
constexpr int kWordsWidth = 46;
constexpr int kBoardBauds[] = {115200, 1000000, 500000, 57600};

const char* describe(BusType type) {
  switch (type) {
    case BusType::kDynamixel:
      return "Dynamixel servos, protocol 2.0";
    case BusType::kCan:
      return "CAN";
    case BusType::kPressureBoard:
      break;
  }
  return "pressure boards";
}

IdRange rangeOf(const BusDescription& bus, const ScanOrder& order) {
  if (!order.any_ids) return order.ids;
  return bus.type == BusType::kDynamixel ? IdRange{0, kMaxServoId} : IdRange{kMinPressureAddress, kMaxPressureAddress};
}

// A percentage that is written over, at a terminal; nothing elsewhere.
ScanProgress showProgress(const std::string& what) {
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  return [what, terminal](int done, int all) {
    if (terminal && done < all) {
      std::printf("\r  %s: %d %%  \r", what.c_str(), 100 * done / all);
      std::fflush(stdout);
    }
    return !isStopAsked();
  };
}

// What was found on one line.
struct Findings {
  std::string problem;  // why the line could not be searched
  std::vector<BusDevice> devices;
  int baud = 0;  // at which they answer
};

Findings searchSerial(BusDescription bus, int baud, const ScanOrder& order) {
  Findings findings;
  bus.baud = findings.baud = baud;
  const std::shared_ptr<ByteStream> line = makePortOpener().serial(bus, findings.problem);
  if (line == nullptr) return findings;
  const ScanProgress progress = showProgress("asking at " + std::to_string(baud) + " baud");
  const auto search = bus.type == BusType::kDynamixel ? findServos : findBoards;
  findings.devices = search(*line, baud, duration(bus.reply_timeout), rangeOf(bus, order), progress);
  std::printf("  %d baud: %zu found\n", baud, findings.devices.size());
  return findings;
}

// At the first rate in `bauds` that is answered.
Findings searchSerial(const BusDescription& bus, std::vector<int> bauds, const ScanOrder& order) {
  if (isPseudoTerminal(bus.port)) bauds.resize(1);  // it has no baud rate: all would be the same
  Findings findings;
  for (std::size_t n = 0; n < bauds.size() && !isStopAsked(); ++n) {
    findings = searchSerial(bus, bauds[n], order);
    if (!findings.problem.empty() || !findings.devices.empty()) break;
  }
  return findings;
}

void printSilence(const CanPort& port, const CanFindings& heard) {
  if (heard.frames > 0 || !heard.devices.empty()) return;
  std::printf(
      "  nothing was heard: are the devices powered, is the bus terminated by 120 ohm at both ends, is this the\n"
      "  bit rate of the devices?\n");
  const auto* socket = dynamic_cast<const SocketCan*>(&port);
  if (socket != nullptr && (socket->errors().unacknowledged > 0 || !heard.acknowledged))
    std::printf("  nobody acknowledges what is sent: no other node takes part at this bit rate\n");
}

Findings searchCan(const BusDescription& bus, const ScanOrder& order) {
  Findings findings;
  const std::shared_ptr<CanPort> port = makePortOpener().can(bus, findings.problem);
  if (port == nullptr) return findings;
  std::printf("  listening for %.3g s%s\n", order.seconds, order.ask ? ", then asking" : "");
  std::fflush(stdout);
  const CanFindings heard =
      findCanDevices(*port, order.seconds, order.ask, rangeOf(bus, order), showProgress("searching"));
  findings.devices = heard.devices;
  for (const std::string& id : heard.strangers) std::printf("  identifier %s is of no device found\n", id.c_str());
  printSilence(*port, heard);
  return findings;
}

void printDevice(const BusDevice& device, const std::string& role) {
  const int width = role.empty() ? 0 : kWordsWidth;
  std::printf("  %-14s %3d  %-*s%s%s\n", describe(device.type), device.id, width, device.words.c_str(),
              role.empty() ? "" : "  ", role.c_str());
}

const BusDevice* find(const std::vector<BusDevice>& devices, const BusDevice& wanted) {
  for (const BusDevice& device : devices)
    if (device.type == wanted.type && device.id == wanted.id) return &device;
  return nullptr;
}

bool printComparison(const std::vector<BusDevice>& expected, const std::vector<BusDevice>& found) {
  bool well = true;
  for (const BusDevice& device : found) {
    const BusDevice* wanted = find(expected, device);
    printDevice(device, wanted != nullptr ? wanted->words : "unexpected: the file has no such device");
  }
  for (const BusDevice& wanted : expected) {
    if (find(found, wanted) != nullptr) continue;
    std::printf("  missing: %s %d (%s); is it powered and wired, and is its number right?\n", describe(wanted.type),
                wanted.id, wanted.words.c_str());
    well = false;
  }
  return well;
}

void printTitle(const BusDescription& bus) {
  std::printf("bus %s: %s at %s\n", bus.name.c_str(), describe(bus.type), bus.port.c_str());
  std::fflush(stdout);
}

Findings search(const BusDescription& bus, const std::vector<int>& bauds, const ScanOrder& order) {
  Findings findings = bus.type == BusType::kCan ? searchCan(bus, order) : searchSerial(bus, bauds, order);
  if (!findings.problem.empty()) std::printf("  %s\n", findings.problem.c_str());
  return findings;
}

std::vector<int> usualBauds(BusType type) {
  if (type == BusType::kDynamixel) return {std::begin(kServoBauds), std::end(kServoBauds)};
  return {std::begin(kBoardBauds), std::end(kBoardBauds)};
}

// First at the file's own baud rate; where nobody answers that, at the others.
std::vector<int> baudsOf(const BusDescription& bus, const ScanOrder& order) {
  if (!order.bauds.empty()) return order.bauds;
  std::vector<int> bauds{bus.baud};
  for (const int baud : usualBauds(bus.type))
    if (baud != bus.baud) bauds.push_back(baud);
  return bauds;
}

bool scanBus(const HardwareDescription& hardware, int number, const ScanOrder& order) {
  const BusDescription& bus = hardware.buses[static_cast<std::size_t>(number)];
  printTitle(bus);
  const Findings findings = search(bus, baudsOf(bus, order), order);
  const bool other_baud = !findings.devices.empty() && bus.type != BusType::kCan && findings.baud != bus.baud;
  if (other_baud) std::printf("  they answer at %d baud, but the file says %d\n", findings.baud, bus.baud);
  const bool complete = printComparison(listExpected(hardware, number), findings.devices);
  return complete && !other_baud && findings.problem.empty();
}

}  // namespace

int scanPort(const BusDescription& bus, const ScanOrder& order) {
  printTitle(bus);
  const Findings findings = search(bus, order.bauds.empty() ? usualBauds(bus.type) : order.bauds, order);
  for (const BusDevice& device : findings.devices) printDevice(device, "");
  if (findings.devices.empty() && findings.problem.empty()) std::printf("  no device answers\n");
  return findings.devices.empty() ? kNotWell : kDone;
}

int scanRobot(const HardwareDescription& hardware, const ScanOrder& order) {
  bool well = true;
  for (int bus = 0; bus < static_cast<int>(hardware.buses.size()) && !isStopAsked(); ++bus)
    well = scanBus(hardware, bus, order) && well;
  std::printf(well ? "all devices of the file answer\n" : "not everything is as the file says\n");
  return well ? kDone : kNotWell;
}

}  // namespace sinew
