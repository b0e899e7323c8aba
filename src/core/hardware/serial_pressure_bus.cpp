#include "sinew/hardware/serial_pressure_bus.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "sinew/hardware/cobs.h"

namespace sinew {
namespace {

constexpr double kBitsPerByte = 10;     // start, 8 data, stop
constexpr double kTurnaround = 0.002;   // s within which a board begins to answer (protocol, section "Timing")
constexpr std::size_t kMaxFrame = 256;  // bytes, without the ending zero
constexpr int kTries = 2;               // of switching off
constexpr std::size_t kReadSize = 512;  // bytes

}  // namespace

SerialPressureBus::SerialPressureBus(LineFactory open_line, int baud, const DeviceTiming& timing,
                                     const std::vector<PressureActuator>& actuators)
    : open_line_(std::move(open_line)),
      baud_(baud),
      period_(duration(timing.period)),
      reply_timeout_(duration(timing.reply_timeout)),
      readings_(actuators.size()) {
  std::map<int, std::vector<PressureActuator>> by_address;
  for (const PressureActuator& a : actuators) by_address[a.settings.address].push_back(a);
  for (const PressureActuator& a : actuators) {
    const auto board = by_address.find(a.settings.address);
    const auto same = [&](const PressureActuator& other) { return other.settings.channel == a.settings.channel; };
    const auto within = std::find_if(board->second.begin(), board->second.end(), same);
    places_.push_back({static_cast<std::size_t>(std::distance(by_address.begin(), board)),
                       static_cast<std::size_t>(within - board->second.begin())});
  }
  for (auto& board : by_address) boards_.emplace_back(board.first, timing, std::move(board.second));
  pending_.assign(boards_.size(), false);
  all_.assign(boards_.size(), true);
  out_.reserve(kMaxFrame + 1);
  frame_.reserve(kMaxFrame);
  packet_.reserve(kMaxFrame);
  problem_.reserve(256);
  collect();
}

Duration SerialPressureBus::lineTime(std::size_t bytes) const {
  return duration(kBitsPerByte * static_cast<double>(bytes) / baud_);
}

// A request and its answer, for which a state is the longest.
Duration SerialPressureBus::exchangeTime(const PressureBoard& board, PressureType request) const {
  return lineTime(pressureFrameSize(request, board.channels()) +
                  pressureFrameSize(PressureType::kState, board.channels()));
}

bool SerialPressureBus::open(std::string& why) {
  line_ = open_line_(why);
  frame_.clear();
  overflown_ = prepared_ = false;
  return isOpen();
}

// --- The line ---

void SerialPressureBus::takeFrame() {
  if (frame_.empty() && !overflown_) return;
  const bool sound = !overflown_ && decodeCobs(frame_.data(), frame_.size(), packet_) &&
                     decodePressureAnswer(packet_.data(), packet_.size(), answer_);
  frame_.clear();
  overflown_ = false;
  if (!sound) {
    ++damaged_;
    ++counters_.corrupted;
    return;
  }
  for (std::size_t b = 0; b < boards_.size(); ++b)
    if (boards_[b].address() == answer_.address && pending_[b] && boards_[b].take(answer_)) return;
  ++counters_.stale;
}

void SerialPressureBus::takeBytes(const std::uint8_t* data, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] == 0) {
      takeFrame();
    } else if (frame_.size() < kMaxFrame) {
      frame_.push_back(data[i]);
    } else {
      overflown_ = true;
    }
  }
}

// Whatever has arrived before a request cannot be its answer.
bool SerialPressureBus::flush() {
  std::fill(pending_.begin(), pending_.end(), false);
  std::uint8_t data[kReadSize];
  for (;;) {
    const StreamResult in = line_->read(data, sizeof data, Duration{0});
    if (in.status == StreamStatus::kClosed) return false;
    if (in.count == 0) return true;
    takeBytes(data, in.count);
  }
}

bool SerialPressureBus::ask(std::size_t board) {
  out_.clear();
  appendPressureRequest(boards_[board].address(), boards_[board].request(), out_);
  pending_[board] = true;
  const Duration patience = lineTime(out_.size()) + reply_timeout_;
  return line_->write(out_.data(), out_.size(), patience).status != StreamStatus::kClosed;
}

bool SerialPressureBus::anyWaiting(std::size_t first, std::size_t last) const {
  for (std::size_t b = first; b < last; ++b)
    if (isWaiting(b)) return true;
  return false;
}

// Until none of the boards first .. last-1 waits for its answer any more, or until the deadline.
bool SerialPressureBus::receive(std::size_t first, std::size_t last, Time deadline) {
  std::uint8_t data[kReadSize];
  while (anyWaiting(first, last)) {
    const Duration left = deadline - line_->now();
    if (left <= Duration{0}) return true;
    const StreamResult in = line_->read(data, sizeof data, left);
    if (in.status == StreamStatus::kClosed) return false;
    takeBytes(data, in.count);
  }
  return true;
}

// Asks the boards in `asked`, whose requests are prepared.
bool SerialPressureBus::exchange(const std::vector<bool>& asked) {
  if (line_ == nullptr || !flush()) return false;
  damaged_ = 0;
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    if (!asked[b]) continue;
    if (!ask(b)) return false;
    const Time over = line_->now() + exchangeTime(boards_[b], boards_[b].request().type) + duration(kTurnaround);
    if (!receive(b, b + 1, over)) return false;
  }
  if (!receive(0, boards_.size(), line_->now() + reply_timeout_)) return false;
  settle();
  return true;
}

void SerialPressureBus::settle() {
  std::uint64_t unanswered = 0;
  for (std::size_t b = 0; b < boards_.size(); ++b) unanswered += isWaiting(b) ? 1 : 0;
  counters_.missing += unanswered > damaged_ ? unanswered - damaged_ : 0;
}

void SerialPressureBus::collect() {
  counters_.device_error = 0;
  for (const PressureBoard& b : boards_) counters_.device_error += b.refusals();
  for (std::size_t i = 0; i < places_.size(); ++i)
    readings_[i] = boards_[places_[i].board].readings()[places_[i].actuator];
}

// --- Set-up ---

void SerialPressureBus::startSetUp(bool) {
  problem_.clear();
  prepared_ = false;
  for (PressureBoard& b : boards_) b.startSetUp();
}

bool SerialPressureBus::checkCycleTime() {
  Duration cycle{0};
  for (const PressureBoard& b : boards_) cycle += exchangeTime(b, PressureType::kSetPoints);
  if (cycle <= period_) return true;
  char words[160];
  std::snprintf(words, sizeof words,
                "a cycle of all pressure boards takes %.1f ms at %d baud, and has %.1f ms: raise baud, or lower rate",
                1e3 * seconds(cycle), baud_, 1e3 * seconds(period_));
  problem_ = words;
  return false;
}

SetUpProgress SerialPressureBus::updateSetUp(Time) {
  const bool enable =
      std::all_of(boards_.begin(), boards_.end(), [](const PressureBoard& b) { return b.awaitsEnable(); }) ||
      std::any_of(boards_.begin(), boards_.end(),
                  [](const PressureBoard& b) { return b.progress() == SetUpProgress::kDone; });
  if (enable && !checkCycleTime()) return SetUpProgress::kFailed;
  std::vector<bool> asked(boards_.size());
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    asked[b] = boards_[b].prepareSetUp(enable);
    if (boards_[b].progress() != SetUpProgress::kDone) continue;
    boards_[b].prepareSetPoints();  // keeps it on while others are not ready yet
    asked[b] = true;
  }
  if (!exchange(asked)) {
    problem_ = "the line to the pressure boards is gone";
    return SetUpProgress::kFailed;
  }
  SetUpProgress progress = SetUpProgress::kDone;
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    if (asked[b] && !boards_[b].answered()) boards_[b].missSetUp();
    if (boards_[b].progress() == SetUpProgress::kFailed) {
      problem_ = boards_[b].problem();
      return SetUpProgress::kFailed;
    }
    if (boards_[b].progress() == SetUpProgress::kBusy) progress = SetUpProgress::kBusy;
  }
  collect();
  return progress;
}

// --- Cycle ---

bool SerialPressureBus::writeSetPoints(const double* set_points, Time) {
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (places_[i].board == b) values_[places_[i].actuator] = set_points[i];
    boards_[b].prepareSetPoints(values_.data());
  }
  prepared_ = true;
  return isOpen();
}

bool SerialPressureBus::read(Time) {
  if (!prepared_)
    for (PressureBoard& b : boards_) b.prepareRead();
  prepared_ = false;
  const bool usable = exchange(all_);
  for (PressureBoard& b : boards_) b.endCycle();
  collect();
  return usable;
}

const bool* SerialPressureBus::flagsOf(std::size_t board, const std::vector<bool>& which) {
  flags_.fill(false);
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (places_[i].board == board) flags_[places_[i].actuator] = which[i];
  return flags_.data();
}

bool SerialPressureBus::sendSetPoints() {
  for (PressureBoard& b : boards_) b.prepareSetPoints();
  prepared_ = true;
  return read(Time{});
}

bool SerialPressureBus::relax(const std::vector<bool>& which, double share) {
  for (std::size_t b = 0; b < boards_.size(); ++b) boards_[b].relax(flagsOf(b, which), share);
  return sendSetPoints();
}

bool SerialPressureBus::switchOff(const std::vector<bool>& which) {
  for (std::size_t b = 0; b < boards_.size(); ++b) boards_[b].switchOff(flagsOf(b, which));
  bool heard = false;
  for (int n = 0; n < kTries && !heard; ++n) {
    if (!sendSetPoints()) return false;
    heard = std::all_of(boards_.begin(), boards_.end(), [](const PressureBoard& b) { return b.answered(); });
  }
  return true;
}

std::string SerialPressureBus::faultDetail(int i) const {
  const Place& place = places_[static_cast<std::size_t>(i)];
  return boards_[place.board].faultDetail(static_cast<int>(place.actuator));
}

}  // namespace sinew
