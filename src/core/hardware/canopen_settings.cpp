#include "sinew/hardware/canopen_settings.h"

#include <cerrno>
#include <cstdlib>
#include <string>

#include "sinew/hardware/canopen_messages.h"

namespace sinew {
namespace {

std::string describeHex(std::int64_t value) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string digits;
  for (; value != 0 || digits.empty(); value /= 16) digits.insert(digits.begin(), kDigits[value % 16]);
  return "0x" + digits;
}

// A whole number, decimal or 0x..., over the full range of 32 bits.
std::int64_t readWhole(const YamlReader& reader, const std::string& key, std::int64_t min, std::int64_t max) {
  const std::string text = reader.text(key);
  const bool hex = text.find("0x") != std::string::npos || text.find("0X") != std::string::npos;
  char* end = nullptr;
  errno = 0;
  const long long value = std::strtoll(text.c_str(), &end, hex ? 16 : 10);
  if (*end != '\0' || errno != 0 || value < min || value > max)
    reader.fail(key, "a whole number from " + std::to_string(min) + " to " + std::to_string(max) + " (" +
                         (min < 0 ? "-" : "") + describeHex(min < 0 ? -min : min) + " to " + describeHex(max) + ")");
  return value;
}

std::uint32_t readWholeOr(const YamlReader& reader, const std::string& key, std::uint32_t otherwise) {
  return reader.has(key) ? static_cast<std::uint32_t>(readWhole(reader, key, 0, 0xFFFFFFFF)) : otherwise;
}

struct ObjectType {
  std::uint8_t size;
  std::int64_t min, max;
};
const std::vector<std::string> kTypeNames = {"u8", "i8", "u16", "i16", "u32", "i32"};
constexpr ObjectType kTypes[] = {{1, 0, 0xFF},         {1, -0x80, 0x7F},   {2, 0, 0xFFFF},
                                 {2, -0x8000, 0x7FFF}, {4, 0, 0xFFFFFFFF}, {4, -0x80000000LL, 0x7FFFFFFF}};

CanopenObject readObject(const YamlReader& reader) {
  CanopenObject object;
  object.index = static_cast<std::uint16_t>(readWhole(reader, "index", 0x1000, 0x9FFF));
  object.subindex = static_cast<std::uint8_t>(reader.integerOr("subindex", 0, 0, 0xFE));
  const int type = reader.choiceOr("type", kTypeNames, -1);
  if (type < 0) reader.fail("type", "one of u8, i8, u16, i16, u32, i32");
  object.size = kTypes[type].size;
  object.value = static_cast<std::uint32_t>(readWhole(reader, "value", kTypes[type].min, kTypes[type].max));
  reader.refuseUnknownKeys();
  return object;
}

CanopenHoming readHoming(const YamlReader& reader) {
  CanopenHoming homing;
  homing.method = static_cast<std::int8_t>(reader.integer("method", -128, 127));
  if (homing.method == 0) reader.fail("method", "a method of object 6098 that the drive knows, not 0");
  homing.search_speed = reader.positive("search_speed");
  homing.zero_speed = reader.positive("zero_speed");
  homing.acceleration = reader.positive("acceleration");
  homing.timeout = reader.positive("timeout");
  reader.refuseUnknownKeys();
  return homing;
}

}  // namespace

CanopenSettings CanopenSettings::read(const YamlReader& reader) {
  CanopenSettings s;
  s.node = static_cast<std::uint8_t>(reader.integer("id", 1, canopen::kMaxNode));
  s.driver_node = static_cast<std::uint8_t>(reader.integerOr("driver_node", canopen::kMaxNode, 1, canopen::kMaxNode));
  if (s.driver_node == s.node) reader.fail("driver_node", "another node than the drive's own");
  s.vendor = readWholeOr(reader, "vendor", 0);
  s.product = readWholeOr(reader, "product", 0);
  s.counts_per_turn = reader.number("counts_per_turn", 4, 1e9);
  s.gear = reader.positiveOr("gear", 1);
  s.absolute_encoder = reader.flagOr("absolute_encoder", false);
  s.effort = static_cast<CanopenEffort>(reader.choiceOr("effort", {"torque", "current", "epos4_current"}, 0));
  s.rated_unit = reader.positiveOr("rated_unit", 1e-3);
  s.speed = static_cast<CanopenSpeed>(reader.choiceOr("speed_unit", {"rpm", "counts"}, 0));
  s.heartbeat = reader.numberOr("heartbeat", 0.1, 0.001, 60);
  if (reader.has("following_window"))
    s.following_window = reader.number("following_window", 1e-9, YamlReader::kInfinity);
  s.limit_time = reader.numberOr("limit_time", s.limit_time, 0, YamlReader::kInfinity);
  s.hold_on_silence = reader.choiceOr("on_silence", {"hold", "let_go"}, 0) == 0;
  for (const YamlReader& object : reader.maps("objects")) s.objects.push_back(readObject(object));
  if (reader.has("drive_homing")) s.homing = readHoming(reader.map("drive_homing"));
  return s;
}

}  // namespace sinew
