#include "sinew/hardware/simulated_can_bus.h"

#include <algorithm>
#include <string>

#include "sinew/common/config_error.h"
#include "sinew/hardware/simulated_slcan_adapter.h"

namespace sinew {
namespace {

using Lock = std::lock_guard<std::mutex>;

constexpr auto kTick = std::chrono::milliseconds(1);  // how finely devices see time pass
constexpr auto kLongAgo = std::chrono::seconds(1);    // a pause over which they are not stepped through
constexpr std::size_t kMaxArrivals = 2000;            // frames that a master may leave unfetched

// Identifiers are sent bit by bit, 0 winning: first the 11 upper bits, then a data frame before a remote one and a
// standard frame before an extended one, then the 18 lower bits.
std::uint64_t calcRank(const CanFrame& f) {
  const std::uint64_t upper = f.extended ? f.id >> 18 : f.id, lower = f.extended ? f.id & 0x3FFFF : 0;
  const std::uint64_t standard_remote = f.remote || f.extended ? 1 : 0;  // RTR, or SRR, which is recessive
  return upper << 21 | standard_remote << 20 | (f.extended ? 1u : 0u) << 19 | lower << 1 | (f.remote ? 1u : 0u);
}

}  // namespace

double calcFrameTime(const CanFrame& frame, int bitrate) {
  const int data = frame.remote ? 0 : 8 * frame.size;
  const int bits = (frame.extended ? 64 : 44) + data;
  const int stuffed = (frame.extended ? 54 : 34) + data;  // start of frame to the end of the CRC
  const int stuff_bits = (stuffed - 1) / 4;
  return static_cast<double>(bits + stuff_bits + 3) / bitrate;
}

SimulatedCanBus::SimulatedCanBus(std::vector<Member> members, int bitrate) : bitrate_(bitrate) {
  std::size_t count = 0;
  for (const Member& m : members) count += m.actuators.size();
  std::vector<bool> taken(count, false);
  places_.resize(count);
  for (Member& m : members) {
    for (std::size_t c = 0; c < m.actuators.size(); ++c) {
      const auto i = static_cast<std::size_t>(m.actuators[c]);
      if (i >= count || taken[i])
        throw ConfigError("number of an actuator on a simulated CAN bus", std::to_string(m.actuators[c]),
                          "0 to " + std::to_string(count - 1) + ", each once");
      taken[i] = true;
      places_[i] = {nodes_.size(), static_cast<int>(c)};
    }
    nodes_.push_back(std::move(m.node));
  }
}

SimulatedCanBus::~SimulatedCanBus() {
  stop();
}

// --- Mechanics and faults ---

void SimulatedCanBus::step(double dt) {
  const Lock lock(mutex_);
  for (const auto& n : nodes_) n->step(dt);
}

void SimulatedCanBus::setLoadTorque(int i, double torque) {
  const Lock lock(mutex_);
  node(i).setLoadTorque(channel(i), torque);
}

double SimulatedCanBus::shaftAngle(int i) const {
  const Lock lock(mutex_);
  return node(i).shaftAngle(channel(i));
}

double SimulatedCanBus::pressure(int i) const {
  const Lock lock(mutex_);
  return node(i).pressure(channel(i));
}

bool SimulatedCanBus::energised(int i) const {
  const Lock lock(mutex_);
  return node(i).energised(channel(i));
}

void SimulatedCanBus::setLineFaults(const LineFaults& faults) {
  const Lock lock(mutex_);
  faults_ = faults;
  random_.seed(faults.seed);
}

LineFaultCounts SimulatedCanBus::lineFaultCounts() const {
  const Lock lock(mutex_);
  return counts_;
}

void SimulatedCanBus::setFrozen(int i, bool frozen) {
  const Lock lock(mutex_);
  node(i).setFrozen(frozen);
}

void SimulatedCanBus::setTemperature(int i, double temperature) {
  const Lock lock(mutex_);
  node(i).setTemperature(temperature);
}

void SimulatedCanBus::setSupplyVoltage(double voltage) {
  const Lock lock(mutex_);
  for (const auto& n : nodes_) n->setSupplyVoltage(voltage);
}

void SimulatedCanBus::powerCycle(int i) {
  const Lock lock(mutex_);
  node(i).powerCycle();
}

void SimulatedCanBus::setLeak(int i, double rate) {
  const Lock lock(mutex_);
  node(i).setLeak(channel(i), rate);
}

// --- The bus ---

void SimulatedCanBus::receive(const CanFrame& frame, Time now) {
  const Lock lock(mutex_);
  advance(now);
  waiting_.push_back({now, kMaster, frame});
}

bool SimulatedCanBus::transmit(CanFrame& frame, Time now) {
  const Lock lock(mutex_);
  advance(now);
  if (arrivals_.empty() || arrivals_.front().due > now) return false;
  frame = arrivals_.front().frame;
  arrivals_.pop_front();
  return true;
}

void SimulatedCanBus::update(Time now) {
  const Lock lock(mutex_);
  advance(now);
}

Time SimulatedCanBus::nextDue() const {
  const Lock lock(mutex_);
  Time due = arrivals_.empty() ? Time::max() : arrivals_.front().due;
  if (!waiting_.empty()) due = std::min(due, calcEnd(findNext()));
  return due;
}

// The frame that wins the bus when it next becomes free: of those that want it by then, the one of the highest rank.
std::size_t SimulatedCanBus::findNext() const {
  const Time start = std::max(line_free_, waiting_.front().ready);
  std::size_t best = 0;
  for (std::size_t i = 1; i < waiting_.size() && waiting_[i].ready <= start; ++i)
    if (calcRank(waiting_[i].frame) < calcRank(waiting_[best].frame)) best = i;
  return best;
}

Time SimulatedCanBus::calcEnd(std::size_t next) const {
  return std::max(line_free_, waiting_.front().ready) + duration(calcFrameTime(waiting_[next].frame, bitrate_));
}

void SimulatedCanBus::advance(Time now) {
  if (updated_ == Time{}) updated_ = now;
  updated_ = std::max(updated_, now - kLongAgo);
  for (;;) {
    const std::size_t next = waiting_.empty() ? 0 : findNext();
    const Time end = waiting_.empty() ? Time::max() : calcEnd(next), tick = updated_ + kTick;
    if (std::min(end, tick) > now) return;
    if (end <= tick) {
      const Waiting sent = waiting_[next];
      waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(next));
      line_free_ = end;
      deliver(sent, end);
    } else {
      updated_ = tick;
      for (std::size_t n = 0; n < nodes_.size(); ++n) {
        out_.clear();
        nodes_[n]->update(tick, out_);
        for (const CanFrame& f : out_) waiting_.push_back({tick, n, f});
      }
    }
  }
}

void SimulatedCanBus::deliver(const Waiting& sent, Time at) {
  if (sent.sender != kMaster) arrive(sent.frame, at);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (n == sent.sender) continue;
    out_.clear();
    nodes_[n]->take(sent.frame, at, out_);
    for (const CanFrame& f : out_) waiting_.push_back({at, n, f});
  }
}

// A device's frame, as the line brings it to the master.
void SimulatedCanBus::arrive(const CanFrame& frame, Time at) {
  const double u = std::uniform_real_distribution<double>(0, 1)(random_);
  const double corrupt = faults_.corrupt, drop = corrupt + faults_.drop, delay = drop + faults_.delay;
  int copies = 1;
  if (u < corrupt) {
    ++counts_.corrupted;
    return;
  }
  if (u < drop) {
    ++counts_.dropped;
    return;
  }
  if (u < delay) {
    ++counts_.delayed;
    at += duration(faults_.delay_time);
  } else if (u < delay + faults_.duplicate) {
    ++counts_.duplicated;
    copies = 2;
  } else {
    ++counts_.sent;
  }
  const auto later = [](Time t, const Arrival& a) { return t < a.due; };
  for (; copies > 0 && arrivals_.size() < kMaxArrivals; --copies)
    arrivals_.insert(std::upper_bound(arrivals_.begin(), arrivals_.end(), at, later), Arrival{at, frame});
}

// --- Serving ---

StreamStatus SimulatedCanBus::poll(CanPort& port, Duration timeout) {
  const Time due = nextDue(), now = port.now();
  const Duration until_due = due == Time::max() ? Duration(kTick) : std::max(Duration{0}, Duration(due - now));
  CanFrame frame;
  const StreamStatus in = port.receive(frame, std::min({timeout, until_due, Duration(kTick)}));
  if (in == StreamStatus::kClosed) return in;
  if (in == StreamStatus::kOk) receive(frame, port.now());
  bool sent = false;
  while (transmit(frame, port.now())) {
    if (port.send(frame, kTick) == StreamStatus::kClosed) return StreamStatus::kClosed;
    sent = true;
  }
  return sent ? StreamStatus::kOk : in;
}

void SimulatedCanBus::start(ByteStream& line) {
  stop();
  adapter_ = std::make_unique<SimulatedSlcanAdapter>(line);
  startThread(adapter_.get());
}

void SimulatedCanBus::start(CanPort& port) {
  stop();
  startThread(&port);
}

void SimulatedCanBus::startThread(CanPort* port) {
  running_ = true;
  thread_ = std::thread(&SimulatedCanBus::serve, this, port);
}

void SimulatedCanBus::stop() {
  running_ = false;
  if (thread_.joinable()) thread_.join();
  adapter_.reset();
}

void SimulatedCanBus::serve(CanPort* port) {
  constexpr auto kWait = std::chrono::milliseconds(20);
  while (running_)
    if (poll(*port, kWait) == StreamStatus::kClosed) {
      update(port->now());
      std::this_thread::sleep_for(kWait);
    }
}

}  // namespace sinew
