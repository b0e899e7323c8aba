#include "sinew/hardware/can_device_bus.h"

#include <algorithm>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr std::uint32_t kSync = 0x080;
constexpr int kMaxDrained = 1000;  // frames in one go, so that a bus full of strangers cannot hold up a cycle

}  // namespace

CanDeviceBus::CanDeviceBus(OpenPort open_port, std::vector<Member> members, const DeviceTiming& timing)
    : open_port_(std::move(open_port)), reply_timeout_(duration(timing.reply_timeout)) {
  std::size_t count = 0;
  for (const Member& m : members) count += m.actuators.size();
  std::vector<bool> taken(count, false);
  places_.resize(count);
  for (Member& m : members) {
    if (static_cast<int>(m.actuators.size()) != m.device->size())
      throw ConfigError("actuators of a CAN device", std::to_string(m.actuators.size()),
                        std::to_string(m.device->size()));
    for (std::size_t channel = 0; channel < m.actuators.size(); ++channel) {
      const auto i = static_cast<std::size_t>(m.actuators[channel]);
      if (i >= count || taken[i])
        throw ConfigError("number of an actuator on a CAN bus", std::to_string(m.actuators[channel]),
                          "0 to " + std::to_string(count - 1) + ", each once");
      taken[i] = true;
      places_[i] = {parts_.size(), static_cast<int>(channel)};
    }
    const std::size_t size = m.actuators.size();
    parts_.push_back({std::move(m.device), std::move(m.actuators), std::vector<double>(size, 0.),
                      std::unique_ptr<bool[]>(new bool[size]()), false});
  }
  readings_.resize(count);
  problem_.reserve(256);
}

bool CanDeviceBus::Sender::send(const CanFrame& frame) {
  if (port == nullptr || closed) return false;
  const StreamStatus status = port->send(frame, std::max(Duration{0}, Duration(deadline - port->now())));
  closed = status == StreamStatus::kClosed;
  if (status != StreamStatus::kOk) ++unsent;
  return status == StreamStatus::kOk;
}

void CanDeviceBus::close() {
  if (port_ != nullptr) damaged_ += port_->damaged();
  port_.reset();
}

bool CanDeviceBus::open(std::string& why) {
  close();
  port_ = open_port_(why);
  return port_ != nullptr;
}

void CanDeviceBus::startSending() {
  sender_.port = port_.get();
  sender_.closed = port_ == nullptr;
  line_gone_ = port_ == nullptr;
  if (port_ != nullptr) sender_.deadline = port_->now() + reply_timeout_;
}

bool CanDeviceBus::isLineThere() const {
  return !sender_.closed && !line_gone_;
}

void CanDeviceBus::show(const CanFrame& frame, Time now) {
  ++received_;
  bool taken = false;
  for (Part& p : parts_) taken = p.device->take(frame, now) || taken;
  if (!taken) ++strangers_;
}

// What has come since the last call belongs to no request under way.
void CanDeviceBus::drain(Time now) {
  if (port_ == nullptr) return;
  CanFrame frame;
  for (int n = 0; n < kMaxDrained; ++n) {
    const StreamStatus status = port_->receive(frame, Duration{0});
    line_gone_ = line_gone_ || status == StreamStatus::kClosed;
    if (status != StreamStatus::kOk) return;
    show(frame, now);
  }
}

void CanDeviceBus::startSetUp(bool home_all) {
  problem_.clear();
  for (Part& p : parts_) {
    p.ready = false;
    p.device->startSetUp(home_all);
  }
  collect();
}

SetUpProgress CanDeviceBus::updateSetUp(Time now) {
  startSending();
  drain(now);
  bool done = true, hold = false;
  for (Part& p : parts_) {
    if (p.ready) {  // holds where it is until the others are ready, its watchdog content
      sendSetPoints(p, now);
      hold = true;
      continue;
    }
    const SetUpProgress progress = p.device->updateSetUp(now, sender_);
    if (progress == SetUpProgress::kFailed) {
      problem_ = p.device->problem();
      collect();
      return progress;
    }
    p.ready = progress == SetUpProgress::kDone;
    done = done && p.ready;
    for (std::size_t c = 0; c < p.set_points.size() && p.ready; ++c) p.set_points[c] = p.device->readings()[c].measured;
  }
  if (hold) sendSync();
  collect();
  if (!isLineThere()) {
    problem_ = "the CAN bus is gone";
    return SetUpProgress::kFailed;
  }
  return done ? SetUpProgress::kDone : SetUpProgress::kBusy;
}

void CanDeviceBus::sendSetPoints(Part& part, Time now) {
  part.device->writeSetPoints(part.set_points.data(), now, sender_);
}

void CanDeviceBus::sendSync() {
  const bool wanted = std::any_of(parts_.begin(), parts_.end(), [](const Part& p) { return p.device->wantsSync(); });
  if (!wanted) return;
  CanFrame sync;
  sync.id = kSync;
  sender_.send(sync);
}

bool CanDeviceBus::writeSetPoints(const double* set_points, Time now) {
  startSending();
  drain(now);
  for (Part& p : parts_) {
    for (std::size_t c = 0; c < p.actuators.size(); ++c)
      p.set_points[c] = set_points[static_cast<std::size_t>(p.actuators[c])];
    sendSetPoints(p, now);
  }
  sendSync();
  asked_ = true;
  return isLineThere();
}

bool CanDeviceBus::isComplete() const {
  return std::all_of(parts_.begin(), parts_.end(), [](const Part& p) { return p.device->complete(); });
}

bool CanDeviceBus::read(Time now) {
  startSending();
  if (!asked_) drain(now);  // after set points, what has come already may answer them
  asked_ = false;
  for (Part& p : parts_) p.device->request(now, sender_);
  CanFrame frame;
  while (port_ != nullptr && !isComplete()) {
    const Duration left = sender_.deadline - port_->now();
    if (left <= Duration{0}) break;
    const StreamStatus status = port_->receive(frame, left);
    line_gone_ = line_gone_ || status == StreamStatus::kClosed;
    if (status != StreamStatus::kOk) break;
    show(frame, now);
  }
  for (Part& p : parts_) p.device->endCycle(now);
  collect();
  return isLineThere();
}

// The flags of one device's actuators; false when none is meant.
bool CanDeviceBus::select(Part& part, const std::vector<bool>& which) {
  bool any = false;
  for (std::size_t c = 0; c < part.actuators.size(); ++c) {
    part.which[c] = which[static_cast<std::size_t>(part.actuators[c])];
    any = any || part.which[c];
  }
  return any;
}

bool CanDeviceBus::relax(const std::vector<bool>& which, double share) {
  startSending();
  for (Part& p : parts_)
    if (select(p, which)) p.device->relax(p.which.get(), share, sender_);
  return isLineThere();
}

bool CanDeviceBus::switchOff(const std::vector<bool>& which) {
  startSending();
  for (Part& p : parts_)
    if (select(p, which)) p.device->switchOff(p.which.get(), sender_);
  return isLineThere();
}

void CanDeviceBus::setZero(int i, double displacement) {
  const Place& place = places_.at(static_cast<std::size_t>(i));
  parts_[place.member].device->setZero(place.channel, displacement);
  collect();
}

std::string CanDeviceBus::faultDetail(int i) const {
  const Place& place = places_.at(static_cast<std::size_t>(i));
  return parts_[place.member].device->faultDetail(place.channel);
}

void CanDeviceBus::collect() {
  counters_ = {};
  counters_.stale = strangers_;
  counters_.corrupted = damaged_ + (port_ != nullptr ? port_->damaged() : 0);
  for (const Part& p : parts_) {
    const BusCounters& c = p.device->counters();
    counters_.corrupted += c.corrupted;
    counters_.missing += c.missing;
    counters_.device_error += c.device_error;
    counters_.stale += c.stale;
    for (std::size_t i = 0; i < p.actuators.size(); ++i)
      readings_[static_cast<std::size_t>(p.actuators[i])] = p.device->readings()[i];
  }
}

}  // namespace sinew
