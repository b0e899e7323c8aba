// Any answers, in any order, to any transfers: the client keeps within its bounds, says only what CiA 301 lets a client
// say, and comes to an end.

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "sinew/hardware/canopen_sdo.h"

namespace {

using namespace sinew;

constexpr std::uint8_t kNode = 5;
constexpr int kTries = 3;

void require(bool holds) {
  if (!holds) std::abort();
}

struct Checker : CanSender {
  bool send(const CanFrame& frame) override {
    require(frame.id == 0x600 + kNode && frame.size == 8 && !frame.extended && !frame.remote);
    require(frame.data[0] >> 5 <= 4);
    ++frames;
    return frames % 7 != 0;  // now and then the line is full
  }
  int frames = 0;
};

void check(const CanopenSdo& sdo) {
  require(sdo.size() <= CanopenSdo::kCapacity);
  sdo.value();
  sdo.signedValue();
  if (sdo.status() == CanopenSdo::Status::kDone) require(sdo.abortCode() == 0);
}

}  // namespace

// Steps of 9 bytes: what to do, and eight of data.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  CanopenSdo sdo(kNode, std::chrono::milliseconds(100), kTries);
  Checker out;
  Time now{std::chrono::seconds(1)};
  std::uint8_t text[CanopenSdo::kCapacity] = {};
  for (std::size_t at = 0; at + 9 <= size; at += 9) {
    const std::uint8_t* bytes = data + at + 1;
    const canopen::ObjectAddress object{static_cast<std::uint16_t>(bytes[1] | bytes[2] << 8), bytes[3]};
    CanFrame frame;
    frame.id = 0x580 + kNode;
    frame.size = data[at] == 0xFF ? std::uint8_t{7} : std::uint8_t{8};
    std::copy_n(bytes, 8, frame.data.begin());
    switch (data[at] % 8) {
      case 0:
        sdo.startUpload(object);
        break;
      case 1:
        std::copy_n(bytes, 8, text);
        sdo.startDownload(object, text, 1 + bytes[0] % CanopenSdo::kCapacity);
        break;
      case 2:
        now += std::chrono::milliseconds(bytes[0]);
        [[fallthrough]];
      case 3:
        sdo.update(now, out);
        break;
      case 4:  // an answer to the object asked for
        canopen::storeNumber(sdo.object().index, 2, &frame.data[1]);
        frame.data[3] = sdo.object().subindex;
        [[fallthrough]];
      default:
        require(sdo.take(frame));
        sdo.update(now, out);
    }
    check(sdo);
  }
  for (int i = 0; i <= kTries + 1; ++i) {
    now += std::chrono::milliseconds(101);
    sdo.update(now, out);
  }
  require(sdo.status() != CanopenSdo::Status::kBusy);
  return 0;
}
