#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sinew/hardware/can_port.h"
#include "sinew/hardware/hardware_description.h"

namespace sinew {

/// A device that has answered, or one that a hardware description expects.
struct BusDevice {
  DeviceType type = DeviceType::kDynamixel;
  int id = 0;
  std::string words;  ///< what it told of itself; or the names of its actuators
};

/// What kind of device, in words.
const char* describe(DeviceType type);

/// Which numbers are asked, both included.
struct IdRange {
  int first = 0, last = 0;
};

/// Told how far a search is: `done` of `all`. Returns whether to go on.
using ScanProgress = std::function<bool(int done, int all)>;

/// Servos that answer a ping at `baud`.
std::vector<BusDevice> findServos(ByteStream& line, int baud, Duration reply_timeout, IdRange ids,
                                  const ScanProgress& progress);

/// Pressure boards that answer a hello at `baud`. A board that restarts when its port is opened is asked again.
std::vector<BusDevice> findBoards(ByteStream& line, int baud, Duration reply_timeout, IdRange ids,
                                  const ScanProgress& progress);

/// What a CAN bus gave.
struct CanFindings {
  std::vector<BusDevice> devices;
  std::uint64_t frames = 0;            ///< that came while nothing was asked
  std::vector<std::string> strangers;  ///< identifiers that belong to none of the devices
  bool acknowledged = true;            ///< some node took what was sent
};

/// Listens to a CAN bus for `seconds`; then, if `ask`, reads who every CANopen node and pressure board in `ids` is,
/// which changes nothing in any of them.
CanFindings findCanDevices(CanPort& port, double seconds, bool ask, IdRange ids, const ScanProgress& progress);

/// Devices that the description expects on its bus number `bus`.
std::vector<BusDevice> listExpected(const HardwareDescription& hardware, int bus);

}  // namespace sinew
