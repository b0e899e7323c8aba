#include "sinew/hardware/hardware_description.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "sinew/common/config_error.h"
#include "sinew/common/yaml_reader.h"
#include "sinew/hardware/command_gate.h"
#include "sinew/hardware/dynamixel_packet.h"

namespace sinew {
namespace {

constexpr double kTiny = 1e-12;
constexpr double kAnyNumber = 1e12;
constexpr double kMinWatchdog = 0.02, kMaxWatchdog = 2.54;  // s: a Dynamixel counts 1 to 127 units of 20 ms
constexpr int kMaxBuses = 8;
constexpr int kUsualAdapterBaud = 115200;  // USB adapters take any

// What a kind of device is called in the file, and the key with what its actuators have in common.
struct DeviceKind {
  DeviceType device;
  BusType bus;
  const char* name;
  const char* common;
  int max_id;
};
constexpr DeviceKind kKinds[] = {
    {DeviceType::kDynamixel, BusType::kDynamixel, "dynamixel", "servo", kMaxServoId},
    {DeviceType::kCanopen, BusType::kCan, "canopen", "drive", 127},
    {DeviceType::kOdrive, BusType::kCan, "odrive", "odrive", 62},
    {DeviceType::kPressureBoard, BusType::kCan, "pressure_board", "pressure_channel", kMaxPressureAddress},
    {DeviceType::kPressureBoard, BusType::kPressureBoard, "pressure_board", "pressure_channel", kMaxPressureAddress},
};

/// One of the choices, which has to be there.
template <typename T>
T choose(const YamlReader& yaml, const std::string& key, const std::vector<std::pair<std::string, T>>& choices) {
  std::string expected;
  for (const auto& c : choices) expected += (expected.empty() ? "" : " or ") + c.first;
  if (!yaml.has(key)) yaml.fail(key, expected);
  const std::string found = yaml.text(key);
  for (const auto& c : choices)
    if (found == c.first) return c.second;
  yaml.fail(key, expected);
}

HomingDescription readHoming(const YamlReader& yaml, DeviceType device) {
  std::vector<std::pair<std::string, HomingMethod>> methods = {{"present", HomingMethod::kPresent},
                                                               {"tension", HomingMethod::kTension}};
  if (device == DeviceType::kCanopen) methods.emplace_back("device", HomingMethod::kDevice);
  HomingDescription homing;
  homing.method = choose(yaml, "method", methods);
  if (homing.method == HomingMethod::kTension) {
    homing.tension = yaml.positive("tension", "N");
    homing.speed = yaml.positive("speed", "m/s");
    homing.travel = yaml.positive("travel", "m");
  }
  yaml.refuseUnknownKeys();
  return homing;
}

WinchDescription readCable(const YamlReader& yaml, DeviceType device) {
  WinchDescription cable;
  cable.spool_radius = yaml.number("spool_radius", 1e-4, 1, "m");
  cable.sign = choose<int>(yaml, "sign", {{"1", 1}, {"+1", 1}, {"-1", -1}});
  cable.torque_constant = yaml.positive("torque_constant", "N m/A");
  cable.tension_max = yaml.positive("tension_max", "N");
  const YamlReader homing = yaml.map("homing");
  cable.homing = readHoming(homing, device);
  if (cable.homing.tension >= cable.tension_max) homing.fail("tension", "N below tension_max");
  return cable;
}

WatchDescription readWatch(const YamlReader& yaml, Quantity quantity) {
  WatchDescription watch;
  watch.difference_max =
      yaml.number("difference_max", kTiny, YamlReader::kInfinity, quantity == Quantity::kPressure ? "Pa" : "m");
  watch.time = yaml.number("time", 0, 60, "s");
  if (quantity == Quantity::kDisplacement) {
    watch.effort_missing = yaml.number("tension_missing", kTiny, YamlReader::kInfinity, "N");
    watch.temperature_max = yaml.number("temperature_max", kTiny, YamlReader::kInfinity, "degC");
    watch.current_max = yaml.number("current_max", kTiny, YamlReader::kInfinity, "A");
  } else {
    watch.pressure_max = yaml.number("pressure_max", kTiny, YamlReader::kInfinity, "Pa");
  }
  yaml.refuseUnknownKeys();
  return watch;
}

/// The actuator's own keys, and below them those that all of its kind have in common.
class ActuatorReader {
 public:
  ActuatorReader(const YamlReader& top, const HardwareDescription& hardware) : top_(top), hardware_(hardware) {}

  ActuatorDescription read(const YamlReader& own) {
    ActuatorDescription a;
    a.name = own.text("name");
    a.bus = readBus(own);
    const DeviceKind& kind = readKind(own, hardware_.buses[static_cast<std::size_t>(a.bus)].type);
    a.device = kind.device;
    const bool common = top_.has(kind.common);
    const YamlReader yaml = common ? own.over(top_.map(kind.common)) : own;
    a.id = yaml.integer("id", 0, kind.max_id);
    readLimits(yaml, a);
    if (yaml.has("watch")) a.watch = readWatch(yaml.map("watch"), a.quantity);
    a.settings = readSettings(yaml, a.device);
    yaml.refuseUnknownKeys();
    return a;
  }

 private:
  int readBus(const YamlReader& own) const {
    if (hardware_.buses.size() == 1 && !own.has("bus")) return 0;
    std::vector<std::pair<std::string, int>> choices;
    for (const BusDescription& b : hardware_.buses) choices.emplace_back(b.name, static_cast<int>(choices.size()));
    return choose(own, "bus", choices);
  }

  static const DeviceKind& readKind(const YamlReader& own, BusType bus) {
    std::vector<std::pair<std::string, const DeviceKind*>> choices;
    for (const DeviceKind& k : kKinds)
      if (k.bus == bus) choices.emplace_back(k.name, &k);
    if (choices.size() == 1 && !own.has("device")) return *choices.front().second;
    return *choose(own, "device", choices);
  }

  static void readLimits(const YamlReader& yaml, ActuatorDescription& a) {
    if (a.device == DeviceType::kPressureBoard) {
      a.quantity = Quantity::kPressure;
      a.channel = yaml.integer("channel", 0, 15);
      a.min = yaml.number("pressure_min", -101325, kAnyNumber, "Pa");
      a.max = yaml.number("pressure_max", a.min + kTiny, kAnyNumber, "Pa");
      a.on_timeout = choose<OnTimeout>(yaml, "on_timeout", {{"hold", OnTimeout::kHold}, {"vent", OnTimeout::kVent}});
    } else {
      a.min = yaml.number("displacement_min", -100, 100, "m");
      a.max = yaml.number("displacement_max", a.min + kTiny, 100, "m");
      a.on_timeout = choose<OnTimeout>(yaml, "on_timeout", {{"hold", OnTimeout::kHold}, {"relax", OnTimeout::kRelax}});
      a.cable = readCable(yaml, a.device);
    }
    a.rate_max = yaml.positive("rate_max", a.quantity == Quantity::kPressure ? "Pa/s" : "m/s");
  }

  static DeviceSettings readSettings(const YamlReader& yaml, DeviceType device) {
    switch (device) {
      case DeviceType::kCanopen:
        return CanopenSettings::read(yaml);
      case DeviceType::kOdrive:
        return OdriveSettings::read(yaml);
      case DeviceType::kPressureBoard:
        return PressureBoardSettings::read(yaml);
      case DeviceType::kDynamixel:
        break;
    }
    return {};
  }

  const YamlReader& top_;
  const HardwareDescription& hardware_;
};

void checkUnique(const std::vector<ActuatorDescription>& actuators, const YamlReader& top) {
  std::set<std::string> names;
  std::set<std::tuple<int, DeviceType, int, int>> places;
  for (const ActuatorDescription& a : actuators) {
    if (!names.insert(a.name).second) top.fail("actuators", "each name once, but '" + a.name + "' comes twice");
    if (!places.insert({a.bus, a.device, a.id, a.channel}).second)
      top.fail("actuators", "each id and channel of a bus once, but id " + std::to_string(a.id) + " of '" + a.name +
                                "' comes twice");
  }
}

BusDescription readBus(const YamlReader& yaml, const std::string& name) {
  BusDescription bus;
  bus.name = name;
  bus.type = choose<BusType>(
      yaml, "protocol",
      {{"dynamixel2", BusType::kDynamixel}, {"can", BusType::kCan}, {"pressure_board", BusType::kPressureBoard}});
  bus.port = yaml.text("port");
  if (bus.type == BusType::kCan) {
    bus.bitrate = yaml.integer("bitrate", 10000, 1000000);
    bus.baud = yaml.integerOr("baud", kUsualAdapterBaud, 9600, 4500000);
  } else {
    bus.baud = yaml.integer("baud", 9600, 4500000);
  }
  bus.simulated = yaml.flagOr("simulated", false);
  bus.reply_timeout = yaml.number("reply_timeout", 1e-4, 1, "s");
  bus.missing_limit = yaml.integer("missing_limit", 1, 10000);
  yaml.refuseUnknownKeys();
  return bus;
}

std::vector<BusDescription> readBuses(const YamlReader& top) {
  std::vector<BusDescription> buses;
  if (top.has("bus") || !top.has("buses")) return {readBus(top.map("bus"), "bus")};
  for (const YamlReader& yaml : top.maps("buses")) {
    const std::string name = yaml.text("name");
    for (const BusDescription& b : buses)
      if (b.name == name) yaml.fail("name", "each name once");
    buses.push_back(readBus(yaml, name));
  }
  if (buses.empty() || buses.size() > kMaxBuses) top.fail("buses", "a list of 1 to " + std::to_string(kMaxBuses));
  return buses;
}

HardwareDescription read(const YamlReader& file) {
  HardwareDescription h;
  const YamlReader top = file.map("hardware");
  h.buses = readBuses(top);
  h.rate = top.number("rate", 1, 2000, "Hz");
  h.command_timeout = top.number("command_timeout", 1e-3, 10, "s");
  h.hold_limit = top.number("hold_limit", 0, 3600, "s");
  h.relax_time = top.number("relax_time", 0, 60, "s");
  h.bus_watchdog = top.number("bus_watchdog", kMinWatchdog, kMaxWatchdog, "s");
  if (h.bus_watchdog < 2 / h.rate) top.fail("bus_watchdog", "s, at least two periods of rate");
  if (top.has("emergency_stop")) {
    const YamlReader stop = top.map("emergency_stop");
    h.emergency_stop.input = stop.text("input");
    stop.refuseUnknownKeys();
  }
  const std::vector<YamlReader> list = top.maps("actuators");
  if (list.empty() || list.size() > kMaxActuators)
    top.fail("actuators", "a list of 1 to " + std::to_string(kMaxActuators));
  ActuatorReader reader(top, h);
  for (const YamlReader& own : list) h.actuators.push_back(reader.read(own));
  checkUnique(h.actuators, top);
  top.refuseUnknownKeys();
  return h;
}

}  // namespace

HardwareDescription HardwareDescription::parse(const std::string& text, const std::string& source) {
  return read(YamlReader::fromText(text, source));
}

HardwareDescription HardwareDescription::load(const std::string& path) {
  return read(YamlReader::fromFile(path));
}

void HardwareDescription::movePorts(const std::string& port) {
  for (BusDescription& b : buses) {
    if (b.isCanInterface() && b.port.compare(0, 4, "vcan") == 0) continue;
    b.port = buses.size() > 1 ? port + "_" + b.name : port;
  }
}

std::vector<std::string> HardwareDescription::names() const {
  std::vector<std::string> out;
  for (const ActuatorDescription& a : actuators) out.push_back(a.name);
  return out;
}

std::vector<Quantity> HardwareDescription::quantities() const {
  std::vector<Quantity> out;
  for (const ActuatorDescription& a : actuators) out.push_back(a.quantity);
  return out;
}

std::vector<int> HardwareDescription::actuatorsOn(int bus) const {
  std::vector<int> out;
  for (std::size_t i = 0; i < actuators.size(); ++i)
    if (actuators[i].bus == bus) out.push_back(static_cast<int>(i));
  return out;
}

DeviceTiming HardwareDescription::timing(int bus) const {
  const BusDescription& b = buses[static_cast<std::size_t>(bus)];
  return {1 / rate, bus_watchdog, b.reply_timeout, b.missing_limit};
}

}  // namespace sinew
