// Brings the devices of a robot up from a terminal: who answers, what do they measure, does each move, where is zero,
// how fast are the buses?

#include <algorithm>
#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "bus_session.h"
#include "bus_text.h"
#include "bus_verbs.h"
#include "zero_file.h"

namespace sinew {
namespace {

namespace options = boost::program_options;

constexpr char kUsage[] =
    R"(usage: bus VERB ... [--yes]

Brings the devices of a robot up, without a ROS master. HARDWARE.yaml is the robot's hardware.yaml.

  bus scan HARDWARE.yaml                    who answers, and is it what the file expects?
  bus scan --port PORT --protocol PROTOCOL  the same of a line about which nothing is known yet
  bus watch HARDWARE.yaml                   what does every device measure?
  bus jog HARDWARE.yaml ACTUATOR DISTANCE   one actuator goes a little way, and back
  bus zero HARDWARE.yaml                    homes, and writes down what the devices count at zero
  bus latency HARDWARE.yaml                 how long do the bus's cycles take?

bus VERB --help tells more. Exit code 0 when all is well, 1 when a device or the robot is not, 2 for a wrong line.
)";

constexpr char kScanUsage[] =
    R"(usage: bus scan HARDWARE.yaml [options]
       bus scan --port PORT --protocol dynamixel2|can|pressure_board [options]

Asks all numbers of a line who is there; on a CAN bus it listens first. Switches nothing on. With a file it says what is
missing and what nobody expected.
)";
constexpr char kWatchUsage[] =
    R"(usage: bus watch HARDWARE.yaml [options]

Sets every device up as the driver does and shows what it measures. Cables are not homed: each counts from where it was
found. Ends with Ctrl-C; everything is then relaxed and switched off.
)";
constexpr char kJogUsage[] =
    R"(usage: bus jog HARDWARE.yaml ACTUATOR DISTANCE [options]

Lets one actuator go by DISTANCE and back, slowly, within the limits of the file, and stops at a fault. DISTANCE has a
unit: 5mm, -2mm (lets out), 10kPa. Every other actuator stays off.
)";
constexpr char kZeroUsage[] =
    R"(usage: bus zero HARDWARE.yaml [options]

Homes every actuator as the file says, and writes what its device counts at zero where the driver looks for it.
)";
constexpr char kLatencyUsage[] =
    R"(usage: bus latency HARDWARE.yaml [options]

Times whole cycles, bus by bus: write set points, read everything. Says what rate that allows, and what holds it up.
)";

/// The command line of one verb: its options, and what comes without a name.
class VerbLine {
 public:
  VerbLine(const char* usage, std::vector<std::string> places) : usage_(usage), places_(std::move(places)) {
    named_.add_options()("help", "this text");
  }

  template <typename T>
  VerbLine& add(const char* name, T& value, const char* unit, const char* words) {
    named_.add_options()(name, options::value(&value)->value_name(unit), words);
    return *this;
  }
  VerbLine& add(const char* name, bool& value, const char* words) {
    named_.add_options()(name, options::bool_switch(&value), words);
    return *this;
  }

  /// False when only help was asked for.
  bool read(const std::vector<std::string>& arguments) {
    options::options_description all;
    all.add(named_).add_options()("place", options::value(&found_));
    options::positional_options_description positional;
    positional.add("place", -1);
    namespace style = options::command_line_style;
    options::variables_map values;
    // Without short options, so that -5mm is a distance.
    options::store(options::command_line_parser(arguments)
                       .options(all)
                       .positional(positional)
                       .style(style::unix_style ^ style::allow_short)
                       .run(),
                   values);
    if (values.count("help") > 0) {
      std::cout << usage_ << "\n" << named_;
      return false;
    }
    options::notify(values);
    if (found_.size() > places_.size()) throw WrongUse("'" + found_[places_.size()] + "' is too much");
    return true;
  }

  bool has(std::size_t place) const { return place < found_.size(); }
  const std::string& at(std::size_t place) const {
    if (!has(place)) throw WrongUse(places_[place] + " is missing");
    return found_[place];
  }

 private:
  const char* usage_;
  std::vector<std::string> places_, found_;
  options::options_description named_{"options"};
};

using Arguments = std::vector<std::string>;

constexpr char kPortWords[] = "in place of the file's ports; with several buses followed by '_' and the bus's name";
constexpr char kYesWords[] = "do not ask before devices are switched on";

void requirePositive(double value, const char* name) {
  if (!(value > 0 && std::isfinite(value))) throw WrongUse(std::string(name) + " must be above 0");
}

HardwareDescription load(const VerbLine& line, const std::string& port) {
  HardwareDescription hardware = HardwareDescription::load(line.at(0));
  if (!port.empty()) hardware.movePorts(port);
  return hardware;
}

BusDescription makeBus(const std::string& port, const std::string& protocol, int bitrate) {
  BusDescription bus;
  bus.name = "at the port";
  bus.port = port;
  bus.bitrate = bitrate;
  bus.baud = 115200;         // of an adapter to a CAN bus
  bus.reply_timeout = 0.02;  // s: adapters keep bytes back for up to 16 ms
  if (protocol == "dynamixel2")
    bus.type = BusType::kDynamixel;
  else if (protocol == "can")
    bus.type = BusType::kCan;
  else if (protocol == "pressure_board")
    bus.type = BusType::kPressureBoard;
  else
    throw WrongUse("--protocol is '" + protocol + "', expected dynamixel2, can or pressure_board");
  return bus;
}

// "7" or "1-20".
IdRange parseIds(const std::string& text) {
  IdRange ids;
  char rest = 0;
  const int numbers = std::sscanf(text.c_str(), "%d-%d%c", &ids.first, &ids.last, &rest);
  if (numbers == 1) ids.last = ids.first;
  const bool sound = (numbers == 1 || numbers == 2) && ids.first >= 0 && ids.first <= ids.last && ids.last <= 252;
  if (!sound) throw WrongUse("--ids is '" + text + "', expected numbers from 0 to 252, as in 1-20");
  return ids;
}

int runScan(const Arguments& arguments) {
  ScanOrder order;
  std::string port, protocol, ids;
  int bitrate = 1000000;
  bool listen = false;
  VerbLine line(kScanUsage, {"HARDWARE.yaml"});
  line.add("port", port, "PORT", "path of a serial port, or name of a CAN interface")
      .add("protocol", protocol, "NAME", "dynamixel2, can or pressure_board, where there is no file")
      .add("baud", order.bauds, "N", "1/s; several may be given; all usual ones when none is")
      .add("bitrate", bitrate, "N", "bit/s of a CAN bus behind a serial adapter; 1000000 when not given")
      .add("ids", ids, "FIRST-LAST", "ask these numbers only")
      .add("seconds", order.seconds, "S", "of listening to a CAN bus; 3 when not given")
      .add("listen", listen, "send nothing on a CAN bus");
  if (!line.read(arguments)) return kDone;
  requirePositive(order.seconds, "--seconds");
  for (const int baud : order.bauds) requirePositive(baud, "--baud");
  order.ask = !listen;
  order.any_ids = ids.empty();
  if (!order.any_ids) order.ids = parseIds(ids);
  if (line.has(0)) {
    if (!protocol.empty()) throw WrongUse("the file says the protocol: leave --protocol out");
    return scanRobot(load(line, port), order);
  }
  if (port.empty() || protocol.empty()) throw WrongUse("HARDWARE.yaml, or --port and --protocol, are missing");
  return scanPort(makeBus(port, protocol, bitrate), order);
}

int runWatch(const Arguments& arguments) {
  WatchOrder order;
  std::string port;
  VerbLine line(kWatchUsage, {"HARDWARE.yaml"});
  line.add("seconds", order.seconds, "S", "to watch for; until Ctrl-C when not given")
      .add("rate", order.rate, "HZ", "of the table; 2 when not given")
      .add("port", port, "PORT", kPortWords)
      .add("yes", order.yes, kYesWords);
  if (!line.read(arguments)) return kDone;
  if (order.seconds != 0) requirePositive(order.seconds, "--seconds");
  requirePositive(order.rate, "--rate");
  return watch(load(line, port), order);
}

int runJog(const Arguments& arguments) {
  JogOrder order;
  std::string port;
  VerbLine line(kJogUsage, {"HARDWARE.yaml", "ACTUATOR", "DISTANCE"});
  line.add("speed", order.speed, "V", "with unit; 5mm/s or 5kPa/s when not given")
      .add("tension", order.tension, "F", "the most that a cable is pulled with, e.g. 5N; the file's when not given")
      .add("pressure", order.pressure, "P", "the most that a channel may have, e.g. 20kPa; the file's when not given")
      .add("port", port, "PORT", kPortWords)
      .add("yes", order.yes, kYesWords);
  if (!line.read(arguments)) return kDone;
  order.actuator = line.at(1);
  order.distance = line.at(2);
  return jog(load(line, port), order);
}

int runZero(const Arguments& arguments) {
  ZeroOrder order;
  std::string port, node = "/hardware_driver";
  VerbLine line(kZeroUsage, {"HARDWARE.yaml"});
  line.add("file", order.file, "FILE", "to write to; where the driver looks when not given")
      .add("node", node, "NAME",
           "name of the driver's node, e.g. /trunk/hardware_driver; /hardware_driver when not given")
      .add("port", port, "PORT", kPortWords)
      .add("yes", order.yes, kYesWords);
  if (!line.read(arguments)) return kDone;
  if (order.file.empty()) order.file = makeZeroPath(node);
  return zero(load(line, port), order);
}

int runLatency(const Arguments& arguments) {
  LatencyOrder order;
  std::string port;
  VerbLine line(kLatencyUsage, {"HARDWARE.yaml"});
  line.add("cycles", order.cycles, "N", "to time; 1000 when not given")
      .add("port", port, "PORT", kPortWords)
      .add("yes", order.yes, kYesWords);
  if (!line.read(arguments)) return kDone;
  requirePositive(order.cycles, "--cycles");
  return measureLatency(load(line, port), order);
}

int run(const Arguments& arguments) {
  constexpr struct {
    const char* name;
    int (*run)(const Arguments&);
  } kVerbs[] = {{"scan", runScan}, {"watch", runWatch}, {"jog", runJog}, {"zero", runZero}, {"latency", runLatency}};
  if (arguments.empty()) throw WrongUse("VERB is missing");
  if (arguments.front() == "--help") {
    std::cout << kUsage;
    return kDone;
  }
  for (const auto& verb : kVerbs)
    if (arguments.front() == verb.name) return verb.run({arguments.begin() + 1, arguments.end()});
  throw WrongUse("'" + arguments.front() + "' is no verb, expected scan, watch, jog, zero or latency");
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  sinew::catchStops();
  try {
    return sinew::run({argv + 1, argv + argc});
  } catch (const boost::program_options::error& error) {
    std::cerr << "bus: " << error.what() << "; see bus --help\n";
    return sinew::kWrongUse;
  } catch (const sinew::WrongUse& error) {
    std::cerr << "bus: " << error.what() << "; see bus --help\n";
    return sinew::kWrongUse;
  } catch (const std::exception& error) {
    std::cerr << "bus: " << error.what() << "\n";
    return sinew::kNotWell;
  }
}
