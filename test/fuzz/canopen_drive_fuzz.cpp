// A drive that answers well for a while, and any frames in between: readings stay finite, only frames of the drive's
// own identifiers leave, and a controlword never leads on by itself after the drive has left operation.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "sinew/hardware/canopen_drive.h"
#include "sinew/hardware/simulated_cia402_drive.h"

namespace {

using namespace sinew;

constexpr std::uint8_t kNode = 5;

void require(bool holds) {
  if (!holds) std::abort();
}

CanopenSettings makeSettings(std::uint8_t kind) {
  CanopenSettings s;
  s.node = kNode;
  s.driver_node = 127;
  s.counts_per_turn = 4096;
  s.gear = 10;
  s.rated_unit = 1e-3;
  s.heartbeat = 0.01;
  s.effort = static_cast<CanopenEffort>(kind % 3);
  s.absolute_encoder = (kind & 4) != 0;
  s.hold_on_silence = (kind & 8) != 0;
  s.homing = {37, 1, 0.1, 10, 1};
  if ((kind & 16) != 0) s.limit_time = 0.05;
  return s;
}

WinchDescription makeCable(std::uint8_t kind) {
  WinchDescription cable;
  cable.spool_radius = 0.01;
  cable.sign = (kind & 32) != 0 ? -1 : 1;
  cable.torque_constant = 0.5;
  cable.tension_max = 20;
  cable.homing.method = (kind & 64) != 0 ? HomingMethod::kDevice : HomingMethod::kPresent;
  return cable;
}

struct Bus : CanSender {
  explicit Bus(std::uint8_t kind)
      : drive(makeSettings(kind), makeCable(kind), {"cable", -0.1, 0.1, 0.2}, {0.01, 0.1, 0.004, 5}), node(kNode, {}) {}

  bool send(const CanFrame& frame) override {
    require(frame.size <= 8 && !frame.extended && !frame.remote);
    require(frame.id == 0x000 || frame.id == 0x200 + kNode || frame.id == 0x600 + kNode || frame.id == 0x77F);
    if (frame.id == 0x000) require(frame.data[1] == kNode);
    if (frame.id == 0x200 + kNode) {
      const unsigned word = frame.data[0] | frame.data[1] << 8;
      require(word == 0x0000 || word == 0x0002 || word == 0x000F);
      constexpr std::uint32_t kGone = kFaultWatchdog | kFaultOff;
      if ((drive.readings()[0].fault & kGone) != 0) require(word != 0x000F);
    }
    if (answers) node.take(frame, now, inbox);
    return true;
  }
  void tick(double dt) {
    now += duration(dt);
    if (!answers) return;
    node.step(dt);
    node.update(now, inbox);
  }
  void deliver() {
    std::vector<CanFrame> frames;
    frames.swap(inbox);
    for (const CanFrame& frame : frames) drive.take(frame, now);
  }
  void cycle(double set_point) {
    deliver();
    drive.writeSetPoints(&set_point, now, *this);
    CanFrame sync;
    sync.id = 0x080;
    if (answers) node.take(sync, now, inbox);
    drive.request(now, *this);
    tick(1e-3);
    deliver();
    drive.endCycle(now);
    tick(9e-3);
  }
  void check() const {
    const ActuatorReading& r = drive.readings()[0];
    for (const double value : {r.measured, r.effort, r.current, r.temperature, r.voltage})
      require(std::isfinite(value));
    require(r.missing >= 0 && (!r.valid || r.missing == 0));
  }

  CanopenDrive drive;
  SimulatedCia402Drive node;
  bool answers = true;
  Time now{std::chrono::seconds(1)};
  std::vector<CanFrame> inbox;
};

}  // namespace

// The first byte chooses the settings; then come steps of 11 bytes: what to do, two of an identifier, and eight of
// data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0 || size > 1 + 11 * 100) return 0;
  Bus bus(data[0]);
  const bool which = true;
  for (std::size_t at = 1; at + 11 <= size; at += 11) {
    const std::uint8_t* bytes = data + at + 3;
    constexpr std::uint32_t kIds[] = {0x080, 0x180, 0x280, 0x580, 0x700, 0x080, 0x180, 0x700};
    CanFrame frame;
    frame.id = data[at + 1] < 250 ? kIds[data[at + 1] % 8] + kNode : data[at + 2] * 8u;
    constexpr std::uint8_t kSizes[] = {8, 6, 2, 8, 1, 8, 6, 1};
    frame.size = data[at + 2] < 240 ? kSizes[data[at + 1] % 8] : static_cast<std::uint8_t>(data[at + 2] % 9);
    frame.extended = data[at + 2] == 0xFF;
    std::copy_n(bytes, 8, frame.data.begin());
    switch (data[at] % 12) {
      case 0:
        bus.drive.startSetUp((bytes[0] & 1) != 0);
        break;
      case 1:
        for (int i = 0; i < 1 + bytes[0] % 100; ++i) {
          bus.deliver();
          if (bus.drive.updateSetUp(bus.now, bus) != SetUpProgress::kBusy) break;
          bus.tick(0.01);
        }
        break;
      case 2:
        bus.cycle((bytes[0] - 128) / 1280.);
        break;
      case 3:
        bus.tick(1e-3 * bytes[0]);
        break;
      case 4:
        bus.drive.relax(&which, bytes[0] / 128., bus);
        break;
      case 5:
        bus.drive.switchOff(&which, bus);
        break;
      case 6:
        bus.drive.setZero(0, (bytes[0] - 128) / 1280.);
        break;
      case 7:
        bus.answers = (bytes[0] & 1) != 0;
        break;
      case 8:
        bus.node.powerCycle();
        break;
      default:
        bus.drive.take(frame, bus.now);
    }
    bus.check();
    bus.drive.faultDetail(0);
  }
  return 0;
}
