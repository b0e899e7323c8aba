#include "sinew/hardware/simulated_serial_bus.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr std::size_t kReadSize = 2048;                // bytes, as long as any frame
constexpr auto kWait = std::chrono::milliseconds(20);  // at most between two looks at whether to stop
constexpr auto kWrite = std::chrono::milliseconds(10);

}  // namespace

void SimulatedSerialBus::receive(const std::uint8_t* data, std::size_t size, Time now) {
  const Lock lock(mutex_);
  take(data, size, now);
}

std::size_t SimulatedSerialBus::transmit(std::uint8_t* data, std::size_t capacity, Time now) {
  const Lock lock(mutex_);
  return answers_.transmit(data, capacity, now);
}

Time SimulatedSerialBus::nextDue() const {
  const Lock lock(mutex_);
  return answers_.nextDue();
}

void SimulatedSerialBus::setLineFaults(const LineFaults& faults) {
  const Lock lock(mutex_);
  answers_.setFaults(faults);
}

LineFaultCounts SimulatedSerialBus::lineFaultCounts() const {
  const Lock lock(mutex_);
  return answers_.counts();
}

StreamStatus SimulatedSerialBus::poll(ByteStream& line, Duration timeout) {
  std::uint8_t data[kReadSize];
  const Time now = line.now(), due = nextDue();
  const Duration until_due = due == Time::max() ? timeout : std::max(Duration{0}, Duration(due - now));
  const StreamResult in = line.read(data, sizeof data, std::min(timeout, until_due));
  if (in.status == StreamStatus::kClosed) return in.status;
  if (in.count > 0) receive(data, in.count, line.now());
  const std::size_t out = transmit(data, sizeof data, line.now());
  if (out > 0 && line.write(data, out, kWrite).status == StreamStatus::kClosed) return StreamStatus::kClosed;
  return in.count + out > 0 ? StreamStatus::kOk : StreamStatus::kTimeout;
}

void SimulatedSerialBus::start(ByteStream& line) {
  stop();
  line_ = &line;
  running_ = true;
  thread_ = std::thread(&SimulatedSerialBus::serve, this);
}

void SimulatedSerialBus::stop() {
  running_ = false;
  if (thread_.joinable()) thread_.join();
}

void SimulatedSerialBus::serve() {
  while (running_)
    if (poll(*line_, kWait) == StreamStatus::kClosed) std::this_thread::sleep_for(kWait);
}

}  // namespace sinew
