// Any frames to the simulated drive: its SDO server, PDOs and network states answer with sound frames, and its shaft
// stays finite.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "sinew/hardware/simulated_cia402_drive.h"

namespace {

using namespace sinew;

constexpr std::uint8_t kNode = 5;

void require(bool holds) {
  if (!holds) std::abort();
}

void check(const std::vector<CanFrame>& out) {
  for (const CanFrame& frame : out) {
    require(frame.size <= 8 && !frame.extended && !frame.remote && frame.id > 0 && frame.id <= 0x77F);
    if (frame.id == 0x580 + kNode) require(frame.size == 8 && frame.data[0] >> 5 <= 4);
    if (frame.id == 0x700 + kNode) require(frame.size == 1);
  }
}

}  // namespace

// Steps of 11 bytes: what to do, two of an identifier, and eight of data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 11 * 200) return 0;
  SimulatedCia402Drive drive(kNode, {});
  Time now{std::chrono::seconds(1)};
  for (std::size_t at = 0; at + 11 <= size; at += 11) {
    constexpr std::uint32_t kIds[] = {0x000,         0x080, 0x600 + kNode, 0x200 + kNode,
                                      0x300 + kNode, 0x77F, 0x600 + kNode, 0x600 + kNode};
    constexpr std::uint8_t kSizes[] = {2, 0, 8, 6, 8, 1, 8, 8};
    std::vector<CanFrame> out;
    CanFrame frame;
    frame.id = data[at + 1] < 250 ? kIds[data[at + 1] % 8] : data[at + 2] * 8u;
    frame.size = data[at + 2] < 240 ? kSizes[data[at + 1] % 8] : static_cast<std::uint8_t>(data[at + 2] % 9);
    std::copy_n(data + at + 3, 8, frame.data.begin());
    switch (data[at] % 16) {
      case 0:
        now += std::chrono::milliseconds(data[at + 3]);
        drive.step(1e-3 * data[at + 3]);
        drive.update(now, out);
        break;
      case 1:
        drive.setLoadTorque(0, (data[at + 3] - 128) / 100.);
        break;
      case 2:
        drive.setTemperature(data[at + 3]);
        break;
      case 3:
        drive.setSupplyVoltage(data[at + 3] / 3.);
        break;
      case 4:
        drive.powerCycle();
        break;
      default:
        drive.take(frame, now, out);
        require(out.size() <= 5);
    }
    check(out);
    require(std::isfinite(drive.shaftAngle(0)) && std::isfinite(drive.motorTorque()));
  }
  return 0;
}
