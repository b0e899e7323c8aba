// Any frames, at any time, to an axis in any state: what it tells stays finite, nothing but its own commands leaves it,
// and no frame is counted twice.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "sinew/hardware/odrive_axis.h"

namespace {

using namespace sinew;

constexpr int kNode = 3;
constexpr double kMaxCurrent = 20 * 0.01 / 0.5;

void require(bool holds) {
  if (!holds) std::abort();
}

float floatAt(const CanFrame& frame, std::size_t at) {
  float value = 0;
  std::memcpy(&value, &frame.data[at], sizeof value);
  return value;
}

struct Checker : CanSender {
  bool send(const CanFrame& frame) override {
    require(!frame.extended && frame.id >> 5 == kNode && frame.size <= 8);
    if ((frame.id & 0x1F) == 0x0C) require(std::isfinite(floatAt(frame, 0)));
    if ((frame.id & 0x1F) == 0x0F)
      require(floatAt(frame, 4) >= 0 && static_cast<double>(floatAt(frame, 4)) < kMaxCurrent + 1e-6);
    return true;
  }
};

OdriveAxis makeAxis(std::uint8_t kind) {
  OdriveSettings settings;
  settings.node = kNode;
  settings.firmware = (kind & 1) != 0 ? OdriveFirmware::k05 : OdriveFirmware::k06;
  settings.cyclic = (kind & 2) != 0;
  if ((kind & 4) != 0) settings.watchdog = {true, 268, 269};
  if ((kind & 16) != 0) settings.input = OdriveInput::kTrapezoidal;
  WinchDescription cable;
  cable.spool_radius = 0.01;
  cable.sign = (kind & 8) != 0 ? -1 : 1;
  cable.torque_constant = 0.5;
  cable.tension_max = 20;
  return OdriveAxis(settings, cable, {"cable", -0.1, 0.1, 0.1}, {0.01, 0.1, 0.002, 10});
}

void check(const OdriveAxis& axis, std::uint64_t frames) {
  const ActuatorReading& r = axis.readings()[0];
  for (const double value : {r.measured, r.effort, r.current, r.temperature, r.voltage}) require(std::isfinite(value));
  require(r.missing >= 0 && (r.valid || r.missing >= 0));
  const BusCounters& c = axis.counters();
  require(c.corrupted + c.stale <= frames);
}

}  // namespace

// The first byte chooses the settings; then come steps of 10 bytes: what to do, which command, and 8 bytes of data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  OdriveAxis axis = makeAxis(data[0]);
  Checker out;
  Time now{std::chrono::seconds(1)};
  std::uint64_t frames = 0;
  for (std::size_t at = 1; at + 10 <= size; at += 10) {
    const std::uint8_t action = data[at];
    const double set_point = (data[at + 2] - 128) / 1280.;
    const bool which = true;
    CanFrame frame;
    frame.id = static_cast<std::uint32_t>(kNode << 5 | (data[at + 1] & 0x1F)) ^ ((data[at + 1] & 0x80u) >> 2);
    frame.extended = action == 0xFF;
    frame.remote = action == 0xFE;
    frame.size = static_cast<std::uint8_t>(action >= 0xF4 && action <= 0xFC ? action - 0xF4 : 8);
    std::memcpy(frame.data.data(), data + at + 2, 8);
    switch (action & 0x0F) {
      case 0:
        axis.startSetUp((data[at + 1] & 1) != 0);
        break;
      case 1:
        axis.updateSetUp(now, out);
        now += std::chrono::milliseconds(data[at + 1]);
        break;
      case 2:
        axis.writeSetPoints(&set_point, now, out);
        axis.request(now, out);
        break;
      case 3:
        axis.endCycle(now);
        now += std::chrono::milliseconds(data[at + 1]);
        break;
      case 4:
        axis.relax(&which, data[at + 1] / 128., out);
        break;
      case 5:
        axis.switchOff(&which, out);
        break;
      case 6:
        axis.setZero(0, set_point);
        break;
      default:
        ++frames;
        axis.take(frame, now);
    }
    check(axis, frames);
    axis.faultDetail(0);
  }
  OdriveSdo sdo;
  CanFrame answer;
  answer.size = static_cast<std::uint8_t>(size % 9);
  std::memcpy(answer.data.data(), data, std::min<std::size_t>(size, 8));
  if (decodeOdrive(answer, sdo)) {
    const CanFrame again = makeOdriveSdoWrite(kNode, sdo);
    require(again.size == answer.size && std::memcmp(&again.data[4], &answer.data[4], sdo.size) == 0);
    require(again.data[1] == answer.data[1] && again.data[2] == answer.data[2]);
  }
  return 0;
}
