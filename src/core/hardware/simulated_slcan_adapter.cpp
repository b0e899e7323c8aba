#include "sinew/hardware/simulated_slcan_adapter.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

namespace sinew {
namespace {

constexpr auto kWriteTime = std::chrono::milliseconds(10);
constexpr std::size_t kMaxCommand = 40;

bool allHex(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
}

}  // namespace

void SimulatedSlcanAdapter::answer(const std::string& text) {
  line_.write(reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), kWriteTime);
}

StreamStatus SimulatedSlcanAdapter::send(const CanFrame& frame, Duration timeout) {
  if (!open_) return StreamStatus::kOk;
  char text[16];
  if (frame.extended)
    std::snprintf(text, sizeof text, "%c%08X%u", frame.remote ? 'R' : 'T', frame.id, unsigned{frame.size});
  else
    std::snprintf(text, sizeof text, "%c%03X%u", frame.remote ? 'r' : 't', frame.id, unsigned{frame.size});
  std::string out = text;
  for (int i = 0; i < frame.size && !frame.remote; ++i) {
    std::snprintf(text, sizeof text, "%02X", unsigned{frame.data[static_cast<std::size_t>(i)]});
    out += text;
  }
  out += '\r';
  return line_.write(reinterpret_cast<const std::uint8_t*>(out.data()), out.size(), timeout).status;
}

StreamStatus SimulatedSlcanAdapter::receive(CanFrame& frame, Duration timeout) {
  const Time deadline = line_.now() + timeout;
  for (;;) {
    while (!pending_.empty()) {
      const char c = pending_.front();
      pending_.erase(pending_.begin());
      if (c != '\r') {
        if (command_.size() < kMaxCommand) command_ += c;
        continue;
      }
      const bool is_frame = obey(frame);
      command_.clear();
      if (is_frame) return StreamStatus::kOk;
    }
    std::uint8_t data[256];
    const StreamResult in = line_.read(data, sizeof data, std::max(Duration{0}, Duration(deadline - line_.now())));
    if (in.status != StreamStatus::kOk) return in.status;
    pending_.append(reinterpret_cast<const char*>(data), in.count);
  }
}

// Whether the command was to send `frame`.
bool SimulatedSlcanAdapter::obey(CanFrame& frame) {
  if (command_.empty()) return answer("\r"), false;
  const char verb = command_[0];
  const std::string rest = command_.substr(1);
  if (verb == 'C' && rest.empty() && open_) {
    open_ = false;
    answer("\r");
  } else if (verb == 'O' && rest.empty() && !open_ && bitrate_digit_ >= 0) {
    open_ = true;
    answer("\r");
  } else if (verb == 'S' && rest.size() == 1 && rest[0] >= '0' && rest[0] <= '8' && !open_) {
    bitrate_digit_ = rest[0] - '0';
    answer("\r");
  } else if (verb == 'V' && rest.empty()) {
    answer("V1013\r");
  } else if (verb == 'N' && rest.empty()) {
    answer("NA123\r");
  } else if (verb == 'F' && rest.empty() && open_) {
    answer("F00\r");
  } else if (open_ && parseFrame(frame)) {
    answer(verb == 't' || verb == 'r' ? "z\r" : "Z\r");
    return true;
  } else {
    answer("\a");
  }
  return false;
}

bool SimulatedSlcanAdapter::parseFrame(CanFrame& frame) const {
  const std::string types = "tTrR";
  const std::size_t type = types.find(command_[0]);
  if (type == std::string::npos || !allHex(command_.substr(1))) return false;
  frame = {};
  frame.extended = type % 2 == 1;
  frame.remote = type >= 2;
  const std::size_t digits = frame.extended ? 8 : 3;
  if (command_.size() < digits + 2) return false;
  const unsigned long id = std::stoul(command_.substr(1, digits), nullptr, 16);
  const int size = command_[digits + 1] - '0';
  if (id > (frame.extended ? 0x1FFFFFFFul : 0x7FFul) || size < 0 || size > 8) return false;
  const std::size_t data_digits = frame.remote ? 0 : 2 * static_cast<std::size_t>(size);
  if (command_.size() != digits + 2 + data_digits) return false;
  frame.id = static_cast<std::uint32_t>(id);
  frame.size = static_cast<std::uint8_t>(size);
  for (std::size_t i = 0; 2 * i < data_digits; ++i)
    frame.data[i] = static_cast<std::uint8_t>(std::stoul(command_.substr(digits + 2 + 2 * i, 2), nullptr, 16));
  return true;
}

}  // namespace sinew
