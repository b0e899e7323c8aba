#include "bus_text.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include "sinew/hardware/actuator_fault.h"

namespace sinew {
namespace {

struct Unit {
  const char* name;
  double factor;  // to SI
};

const std::vector<Unit> kLengths = {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}};
const std::vector<Unit> kPressures = {{"kPa", 1e3}, {"Pa", 1}, {"mbar", 1e2}, {"bar", 1e5}};
const std::vector<Unit> kForces = {{"N", 1}};

const std::vector<Unit>& unitsOf(Quantity quantity) {
  return quantity == Quantity::kPressure ? kPressures : kLengths;
}

std::string listUnits(const std::vector<Unit>& units, const std::string& suffix) {
  std::string list;
  for (const Unit& unit : units) list += (list.empty() ? "" : ", ") + std::string(unit.name) + suffix;
  return list;
}

double parse(const std::string& text, const std::vector<Unit>& units, const std::string& suffix,
             const std::string& what) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  const bool is_number = end != text.c_str() && std::isfinite(number);
  while (*end == ' ') ++end;
  for (const Unit& unit : units)
    if (is_number && end == unit.name + suffix) return number * unit.factor;
  const std::string example = std::string("5") + units.front().name + suffix;
  throw WrongUse(what + " is '" + text + "', expected a number with its unit (" + listUnits(units, suffix) +
                 "), as in " + example);
}

template <typename... Values>
std::string format(const char* text, Values... values) {
  char out[256];
  std::snprintf(out, sizeof out, text, values...);
  return out;
}

// What a device does not tell is 0.
std::string formatTold(const char* text, double value) {
  return value == 0 ? "-" : format(text, value);
}

constexpr char kRow[] = "%-*s %11s %10s %8s %8s %7s  %-7s  %s";

}  // namespace

double parseDistance(const std::string& text, Quantity quantity, const std::string& what) {
  return parse(text, unitsOf(quantity), "", what);
}

double parseSpeed(const std::string& text, Quantity quantity, const std::string& what) {
  return parse(text, unitsOf(quantity), "/s", what);
}

double parseForce(const std::string& text, const std::string& what) {
  return parse(text, kForces, "", what);
}

std::string formatDistance(double distance, Quantity quantity) {
  return quantity == Quantity::kPressure ? format("%.1f kPa", 1e-3 * distance) : format("%.2f mm", 1e3 * distance);
}

std::string formatEffort(double effort, Quantity quantity) {
  return quantity == Quantity::kPressure ? format("%.1f kPa", 1e-3 * effort) : format("%.1f N", effort);
}

bool isAllowed(const std::string& deed, bool yes) {
  std::printf("%s\n", deed.c_str());
  std::fflush(stdout);
  if (yes) return true;
  if (isatty(STDIN_FILENO) == 0) throw WrongUse("nobody can be asked without a terminal: allow it by --yes");
  std::printf("Go on? [y/N] ");
  std::fflush(stdout);
  std::string answer;
  return std::getline(std::cin, answer) && (answer == "y" || answer == "Y" || answer == "yes");
}

int calcWidth(const std::vector<std::string>& names) {
  std::size_t width = std::strlen("actuator");
  for (const std::string& name : names) width = std::max(width, name.size());
  return static_cast<int>(width);
}

std::string makeReadingHeader(int width) {
  return format(kRow, width, "actuator", "measured", "effort", "current", "temp.", "supply", "zero", "condition");
}

std::string makeReadingRow(const std::string& name, int width, Quantity quantity, const ActuatorReading& reading) {
  const char* condition = reading.fault == 0 && !reading.valid ? "no answer this time" : describeFault(reading.fault);
  return format(kRow, width, name.c_str(), formatDistance(reading.measured, quantity).c_str(),
                formatEffort(reading.effort, quantity).c_str(), formatTold("%.2f A", reading.current).c_str(),
                formatTold("%.0f degC", reading.temperature).c_str(), formatTold("%.1f V", reading.voltage).c_str(),
                reading.zero_valid ? "valid" : "unknown", condition);
}

}  // namespace sinew
