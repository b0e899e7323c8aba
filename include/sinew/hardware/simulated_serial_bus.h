#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>

#include "sinew/hardware/answer_queue.h"
#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/simulated_bus.h"

namespace sinew {

/// What simulated devices on one serial line share: the line, its time, its faults, and the thread that serves it.
class SimulatedSerialBus : public SimulatedBus {
 public:
  void start(ByteStream& line) override;
  void stop() override;
  /// Serves once from the calling thread: waits up to `timeout` for bytes or for an answer that falls due, takes and
  /// sends what there is. kClosed when the line is gone, kTimeout when nothing happened.
  StreamStatus poll(ByteStream& line, Duration timeout);

  /// The line's two halves, for a line without a stream: bytes that arrive at `now`, ...
  void receive(const std::uint8_t* data, std::size_t size, Time now);
  /// ... bytes due at `now` (at most `capacity` of them; returns how many), ...
  std::size_t transmit(std::uint8_t* data, std::size_t capacity, Time now);
  /// ... and when the next bytes fall due; Time::max() when no answer is waiting.
  Time nextDue() const;

  void setLineFaults(const LineFaults& faults) override;
  LineFaultCounts lineFaultCounts() const override;

 protected:
  /// `baud` sets the time that frames spend on the line.
  explicit SimulatedSerialBus(int baud) : answers_(baud) {}
  /// A derived class stops first: its devices answer from the thread.
  ~SimulatedSerialBus() override = default;

  /// Bytes of the master that arrive at `now`; answers go into `answers_`. The lock is held.
  virtual void take(const std::uint8_t* data, std::size_t size, Time now) = 0;

  using Lock = std::lock_guard<std::mutex>;
  mutable std::mutex mutex_;
  AnswerQueue answers_;

 private:
  void serve();

  std::thread thread_;
  std::atomic<bool> running_{false};
  ByteStream* line_ = nullptr;
};

}  // namespace sinew
