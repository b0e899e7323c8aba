// Any bytes from an adapter: what comes out as a frame is one, comes back when it is written and read again, and says
// the same however the bytes arrive.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "sinew/hardware/slcan_codec.h"
#include "sinew/hardware/slcan_port.h"

namespace {

using namespace sinew;

void require(bool holds) {
  if (!holds) std::abort();
}

bool same(const CanFrame& a, const CanFrame& b) {
  return a.id == b.id && a.extended == b.extended && a.remote == b.remote && a.size == b.size && a.data == b.data;
}

void checkFrame(const CanFrame& frame) {
  require(frame.size <= 8 && frame.id <= (frame.extended ? 0x1FFFFFFFu : 0x7FFu));
  for (std::size_t i = frame.remote ? 0 : frame.size; i < 8; ++i) require(frame.data[i] == 0);
  const std::unique_ptr<std::uint8_t[]> line(new std::uint8_t[kMaxSlcanLine]);  // its end is watched
  const std::size_t size = encodeSlcan(frame, line.get());
  require(size <= kMaxSlcanLine && line[size - 1] == '\r');
  SlcanDecoder decoder;
  for (std::size_t i = 0; i + 1 < size; ++i) require(decoder.put(line[i]) == SlcanEvent::kNone);
  require(decoder.put('\r') == SlcanEvent::kFrame && same(decoder.frame(), frame));
}

// Gives the input in pieces whose sizes it chooses itself.
class Pieces : public ByteStream {
 public:
  Pieces(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration) override {
    if (size_ == 0) return {StreamStatus::kTimeout, 0};
    std::size_t count = std::min<std::size_t>(std::size_t{1} + data_[0] % 7, std::min(size_, capacity));
    std::memcpy(data, data_, count);
    data_ += count;
    size_ -= count;
    return {StreamStatus::kOk, count};
  }
  StreamResult write(const std::uint8_t*, std::size_t size, Duration) override { return {StreamStatus::kOk, size}; }
  Time now() const override { return Time{std::chrono::seconds(1)}; }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  SlcanDecoder decoder;
  std::size_t ends = 0, events = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const SlcanEvent event = decoder.put(data[i]);
    const bool is_end = data[i] == '\r' || data[i] == '\a';
    require((event != SlcanEvent::kNone) == is_end);
    require((event == SlcanEvent::kError) == (data[i] == '\a'));
    if (is_end) ++ends;
    if (event != SlcanEvent::kNone) ++events;
    if (event == SlcanEvent::kFrame) checkFrame(decoder.frame());
  }
  require(ends == events);
  SlcanPort port;
  if (!port.open(std::make_shared<Pieces>(data, size), 500000)) return 0;
  CanFrame frame;
  while (port.receive(frame, Duration{0}) == StreamStatus::kOk) checkFrame(frame);
  return 0;
}
