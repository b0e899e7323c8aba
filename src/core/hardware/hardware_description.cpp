#include "sinew/hardware/hardware_description.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <sstream>

#include "sinew/common/config_error.h"
#include "sinew/hardware/command_gate.h"
#include "sinew/hardware/dynamixel_packet.h"

namespace sinew {
namespace {

/// A map of the file, its name in full, and the map that fills in what it leaves out.
class Section {
 public:
  Section(const YAML::Node& node, std::string path, const YAML::Node& common = {}, std::string common_path = {})
      : node_(node), path_(std::move(path)), common_(common), common_path_(std::move(common_path)) {
    if (!node_.IsMap()) throw ConfigError(path_, describe(node_), "a map");
  }

  std::string nameOf(const std::string& key) const { return path_ + (path_.back() == ' ' ? "" : ".") + key; }

  YAML::Node require(const std::string& key, const std::string& expected) {
    known_.insert(key);
    if (const YAML::Node found = std::as_const(node_)[key]) return found;
    if (common_.IsMap())
      if (const YAML::Node found = std::as_const(common_)[key]) return found;
    throw ConfigError(nameOf(key) + (common_path_.empty() ? "" : " (or " + common_path_ + "." + key + ")"), "nothing",
                      expected);
  }

  std::string text(const std::string& key, const std::string& expected) {
    const YAML::Node n = require(key, expected);
    if (!n.IsScalar() || n.Scalar().empty()) throw ConfigError(nameOf(key), describe(n), expected);
    return n.Scalar();
  }

  bool flag(const std::string& key) {
    const YAML::Node n = require(key, "true or false");
    bool value = false;
    if (!n.IsScalar() || !YAML::convert<bool>::decode(n, value))
      throw ConfigError(nameOf(key), describe(n), "true or false");
    return value;
  }

  double number(const std::string& key, double min, double max, const std::string& expected) {
    const YAML::Node n = require(key, expected);
    double value = 0;
    if (!n.IsScalar() || !YAML::convert<double>::decode(n, value) || !(value >= min && value <= max))
      throw ConfigError(nameOf(key), describe(n), expected);
    return value;
  }

  int integer(const std::string& key, int min, int max, const std::string& expected) {
    const double value = number(key, min, max, expected);
    if (value != std::floor(value)) throw ConfigError(nameOf(key), std::to_string(value), expected);
    return static_cast<int>(value);
  }

  Section section(const std::string& key) { return Section(require(key, "a map"), nameOf(key)); }

  /// Call after the last key: whatever is left over is a misspelling.
  void finish() const {
    for (const auto& entry : node_) {
      const std::string key = entry.first.as<std::string>();
      if (known_.count(key) == 0) throw ConfigError(nameOf(key), "an unknown key", list());
    }
  }

  const std::set<std::string>& known() const { return known_; }

  static std::string describe(const YAML::Node& n) {
    if (!n || n.IsNull()) return "nothing";
    if (n.IsScalar()) return "'" + n.Scalar() + "'";
    return n.IsMap() ? "a map" : "a list";
  }

 private:
  std::string list() const {
    std::string out = "one of";
    for (const std::string& k : known_) out += " " + k;
    return out;
  }

  YAML::Node node_;
  std::string path_;
  YAML::Node common_;
  std::string common_path_;
  std::set<std::string> known_;
};

constexpr double kTiny = 1e-12;

template <typename T>
T choose(Section& section, const std::string& key, const std::vector<std::pair<const char*, T>>& choices) {
  std::string expected;
  for (const auto& c : choices) expected += (expected.empty() ? "" : " or ") + std::string(c.first);
  const std::string found = section.text(key, expected);
  for (const auto& c : choices)
    if (found == c.first) return c.second;
  throw ConfigError(section.nameOf(key), "'" + found + "'", expected);
}

HomingDescription readHoming(Section section) {
  HomingDescription homing;
  homing.method = choose<HomingMethod>(section, "method",
                                       {{"present", HomingMethod::kPresent}, {"tension", HomingMethod::kTension}});
  if (homing.method == HomingMethod::kTension) {
    homing.tension = section.number("tension", kTiny, 1e4, "N above 0");
    homing.speed = section.number("speed", kTiny, 1, "m/s above 0");
    homing.travel = section.number("travel", kTiny, 10, "m above 0");
  }
  section.finish();
  return homing;
}

ActuatorDescription readActuator(Section& section) {
  ActuatorDescription a;
  a.name = section.text("name", "a name");
  a.id = static_cast<std::uint8_t>(section.integer("id", 0, kMaxServoId, "a bus id, 0 to 252"));
  a.spool_radius = section.number("spool_radius", 1e-4, 1, "m, 0.0001 to 1");
  a.sign = choose<int>(section, "sign", {{"1", 1}, {"+1", 1}, {"-1", -1}});
  a.displacement_min = section.number("displacement_min", -100, 100, "m");
  a.displacement_max = section.number("displacement_max", a.displacement_min + kTiny, 100, "m above displacement_min");
  a.rate_max = section.number("rate_max", kTiny, 100, "m/s above 0");
  a.tension_max = section.number("tension_max", kTiny, 1e5, "N above 0");
  a.torque_constant = section.number("torque_constant", kTiny, 1e3, "N m/A above 0");
  a.on_timeout = choose<OnTimeout>(section, "on_timeout", {{"hold", OnTimeout::kHold}, {"relax", OnTimeout::kRelax}});
  a.homing = readHoming(section.section("homing"));
  if (a.homing.tension >= a.tension_max)
    throw ConfigError(section.nameOf("homing.tension"), std::to_string(a.homing.tension), "N below tension_max");
  section.finish();
  return a;
}

void checkUnique(const std::vector<ActuatorDescription>& actuators, const std::string& path) {
  std::set<std::string> names;
  std::set<int> ids;
  for (const ActuatorDescription& a : actuators) {
    if (!names.insert(a.name).second) throw ConfigError(path + ".name", "'" + a.name + "' twice", "each name once");
    if (!ids.insert(a.id).second) throw ConfigError(path + ".id", std::to_string(a.id) + " twice", "each id once");
  }
}

void readBus(Section bus, HardwareDescription& h) {
  choose<int>(bus, "protocol", {{"dynamixel2", 0}});
  h.port = bus.text("port", "the path of a serial port");
  h.baud = bus.integer("baud", 9600, 4500000, "baud, 9600 to 4500000");
  h.simulated = bus.flag("simulated");
  h.reply_timeout = bus.number("reply_timeout", 1e-4, 1, "s, 0.0001 to 1");
  h.missing_limit = bus.integer("missing_limit", 1, 10000, "a number of cycles, at least 1");
  bus.finish();
}

HardwareDescription read(const YAML::Node& root, const std::string& source) {
  HardwareDescription h;
  Section file(root, source + ": ");
  Section top = file.section("hardware");
  readBus(top.section("bus"), h);
  h.rate = top.number("rate", 1, 2000, "Hz, 1 to 2000");
  h.command_timeout = top.number("command_timeout", 1e-3, 10, "s, 0.001 to 10");
  h.hold_limit = top.number("hold_limit", 0, 3600, "s, 0 to 3600");
  h.relax_time = top.number("relax_time", 0, 60, "s, 0 to 60");
  h.bus_watchdog = top.number("bus_watchdog", 0.02, 2.54, "s, 0.02 to 2.54 (the devices count 20 ms units)");
  if (h.bus_watchdog < 2 / h.rate)
    throw ConfigError(top.nameOf("bus_watchdog"), std::to_string(h.bus_watchdog), "s, at least two periods of rate");
  const YAML::Node common = top.require("servo", "a map with what all actuators have in common");
  const YAML::Node list = top.require("actuators", "a list of actuators");
  if (!list.IsSequence() || list.size() == 0 || list.size() > kMaxActuators)
    throw ConfigError(top.nameOf("actuators"), Section::describe(list) + " of " + std::to_string(list.size()),
                      "a list of 1 to " + std::to_string(kMaxActuators));
  std::set<std::string> known;
  for (std::size_t i = 0; i < list.size(); ++i) {
    Section section(list[i], top.nameOf("actuators[" + std::to_string(i) + "]"), common, top.nameOf("servo"));
    h.actuators.push_back(readActuator(section));
    known = section.known();
  }
  for (const auto& entry : common)
    if (known.count(entry.first.as<std::string>()) == 0)
      throw ConfigError(top.nameOf("servo." + entry.first.as<std::string>()), "an unknown key", "a key of an actuator");
  checkUnique(h.actuators, top.nameOf("actuators"));
  top.finish();
  return h;
}

}  // namespace

HardwareDescription HardwareDescription::parse(const std::string& text, const std::string& source) {
  try {
    return read(YAML::Load(text), source);
  } catch (const YAML::Exception& e) {
    throw ConfigError(source + ": " + e.what());
  }
}

HardwareDescription HardwareDescription::load(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError("hardware description", "'" + path + "'", "a readable YAML file");
  std::ostringstream text;
  text << file.rdbuf();
  return parse(text.str(), path);
}

std::vector<std::string> HardwareDescription::names() const {
  std::vector<std::string> out;
  for (const ActuatorDescription& a : actuators) out.push_back(a.name);
  return out;
}

std::vector<std::uint8_t> HardwareDescription::ids() const {
  std::vector<std::uint8_t> out;
  for (const ActuatorDescription& a : actuators) out.push_back(a.id);
  return out;
}

}  // namespace sinew
