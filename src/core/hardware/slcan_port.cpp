#include "sinew/hardware/slcan_port.h"

#include <algorithm>
#include <cstring>

namespace sinew {
namespace {

constexpr int kBitrates[] = {10000, 20000, 50000, 100000, 125000, 250000, 500000, 800000, 1000000};  // S0 to S8
constexpr int kCloseTries = 3;

// The command that sets a bit rate; empty when the protocol has none for it.
std::string makeBitrateCommand(int bitrate) {
  const auto* found = std::find(std::begin(kBitrates), std::end(kBitrates), bitrate);
  return found == std::end(kBitrates) ? "" : "S" + std::to_string(found - std::begin(kBitrates)) + "\r";
}

}  // namespace

bool SlcanPort::fail(const std::string& why) {
  error_ = why;
  line_.reset();
  return false;
}

bool SlcanPort::open(std::shared_ptr<ByteStream> line, int bitrate, Duration timeout) {
  close();
  const std::string set_bitrate = makeBitrateCommand(bitrate);
  if (set_bitrate.empty())
    return fail("bit rate " + std::to_string(bitrate) +
                ": an SLCAN adapter makes 10000, 20000, 50000, 100000, 125000, 250000, 500000, 800000 or 1000000");
  line_ = std::move(line);
  decoder_ = {};
  begin_ = end_ = 0;
  damaged_ = 0;
  error_.clear();
  // A first return ends whatever an earlier user left unfinished. A channel that is closed already may refuse.
  Answer answer = Answer::kNone;
  for (int n = 0; n < kCloseTries && answer == Answer::kNone; ++n) answer = ask("\rC\r", timeout);
  while (answer != Answer::kClosed && answer != Answer::kNone)
    answer = ask("", timeout / 10);  // what is still on its way
  if (answer == Answer::kClosed) return fail("the adapter is gone");
  decoder_ = {};
  answer = ask(set_bitrate.c_str(), timeout);
  if (answer == Answer::kNone) return fail("nobody answers: is it an adapter with SLCAN (LAWICEL) firmware?");
  if (answer != Answer::kOk) return fail("the adapter refuses bit rate " + std::to_string(bitrate));
  if (ask("O\r", timeout) != Answer::kOk) return fail("the adapter does not open its CAN channel");
  return true;
}

void SlcanPort::close() {
  if (line_ == nullptr) return;
  line_->write(reinterpret_cast<const std::uint8_t*>("C\r"), 2, Duration{0});
  line_.reset();
}

StreamStatus SlcanPort::gone() {
  line_.reset();
  error_ = "the adapter is gone";
  return StreamStatus::kClosed;
}

StreamStatus SlcanPort::nextEvent(SlcanEvent& event, Time deadline) {
  for (;;) {
    while (begin_ < end_)
      if ((event = decoder_.put(buffer_[begin_++])) != SlcanEvent::kNone) return StreamStatus::kOk;
    const Duration left = std::max(Duration{0}, Duration(deadline - line_->now()));
    const StreamResult in = line_->read(buffer_.data(), buffer_.size(), left);
    if (in.status != StreamStatus::kOk) return in.status;
    begin_ = 0;
    end_ = in.count;
  }
}

SlcanPort::Answer SlcanPort::ask(const char* command, Duration timeout) {
  const Time deadline = line_->now() + timeout;
  const std::size_t size = std::strlen(command);
  if (size > 0) {
    const StreamResult out = line_->write(reinterpret_cast<const std::uint8_t*>(command), size, timeout);
    if (out.status == StreamStatus::kClosed) return Answer::kClosed;
  }
  SlcanEvent event = SlcanEvent::kNone;
  for (;;) {
    const StreamStatus status = nextEvent(event, deadline);
    if (status != StreamStatus::kOk) return status == StreamStatus::kClosed ? Answer::kClosed : Answer::kNone;
    if (event == SlcanEvent::kOk) return Answer::kOk;
    if (event == SlcanEvent::kError) return Answer::kError;
  }
}

StreamStatus SlcanPort::send(const CanFrame& frame, Duration timeout) {
  if (line_ == nullptr) return StreamStatus::kClosed;
  std::uint8_t out[kMaxSlcanLine];
  const std::size_t size = encodeSlcan(frame, out);
  const StreamResult result = line_->write(out, size, timeout);
  return result.status == StreamStatus::kClosed ? gone() : result.status;
}

StreamStatus SlcanPort::receive(CanFrame& frame, Duration timeout) {
  if (line_ == nullptr) return StreamStatus::kClosed;
  const Time deadline = line_->now() + timeout;
  SlcanEvent event = SlcanEvent::kNone;
  for (;;) {
    const StreamStatus status = nextEvent(event, deadline);
    if (status == StreamStatus::kClosed) return gone();
    if (status == StreamStatus::kTimeout) return status;
    if (event == SlcanEvent::kError || event == SlcanEvent::kDamaged) ++damaged_;
    if (event != SlcanEvent::kFrame) continue;
    frame = decoder_.frame();
    return StreamStatus::kOk;
  }
}

}  // namespace sinew
