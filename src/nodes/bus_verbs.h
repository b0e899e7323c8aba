#pragma once

#include <string>
#include <vector>

#include "bus_scan.h"
#include "sinew/hardware/hardware_description.h"

namespace sinew {

// The verbs of `rosrun sinew bus`. Each prints to standard output and returns the exit code; each throws WrongUse for a
// wrong command line.

constexpr int kDone = 0;
constexpr int kNotWell = 1;
constexpr int kWrongUse = 2;

struct ScanOrder {
  std::vector<int> bauds;  ///< empty: those of the description, or all that are usual
  IdRange ids;
  bool any_ids = true;  ///< all that the protocol has, in place of `ids`
  double seconds = 3;   ///< of listening to a CAN bus
  bool ask = true;      ///< on a CAN bus
};
/// Searches one line about which nothing is known but the port and the protocol.
int scanPort(const BusDescription& bus, const ScanOrder& order);
/// Searches the lines of a robot, and compares.
int scanRobot(const HardwareDescription& hardware, const ScanOrder& order);

struct WatchOrder {
  double seconds = 0;  ///< 0: until it is stopped
  double rate = 2;     ///< Hz of the table
  bool yes = false;
};
int watch(HardwareDescription hardware, const WatchOrder& order);

struct JogOrder {
  std::string actuator, distance, speed, tension, pressure;  ///< as typed; the last three may be empty
  bool yes = false;
};
int jog(const HardwareDescription& hardware, const JogOrder& order);

struct ZeroOrder {
  std::string file;
  bool yes = false;
};
int zero(const HardwareDescription& hardware, const ZeroOrder& order);

struct LatencyOrder {
  int cycles = 1000;
  bool yes = false;
};
int measureLatency(HardwareDescription hardware, const LatencyOrder& order);

}  // namespace sinew
