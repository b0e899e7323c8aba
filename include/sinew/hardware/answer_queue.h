#pragma once

#include <cstdint>
#include <deque>
#include <random>
#include <vector>

#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/line_faults.h"

namespace sinew {

/// Frames of simulated devices on their way over a serial line: each takes its time, and a bad line damages, loses,
/// delays or doubles some.
class AnswerQueue {
 public:
  using Bytes = std::vector<std::uint8_t>;

  explicit AnswerQueue(int baud) : baud_(baud) {}

  /// Bytes of the master occupied the line from `start` on; returns when they are over.
  Time occupy(std::size_t bytes, Time start);
  /// When the last frame so far has left the line.
  Time lineFree() const { return line_free_; }
  /// A frame of a device that may begin to send at `ready`.
  void send(Bytes frame, Time ready);
  /// Frames due at `now` that fit into `capacity` bytes; returns how many bytes those are.
  std::size_t transmit(std::uint8_t* data, std::size_t capacity, Time now);
  /// When the next frame falls due; Time::max() without any.
  Time nextDue() const { return frames_.empty() ? Time::max() : frames_.front().due; }

  /// Restarts the random numbers too.
  void setFaults(const LineFaults& faults);
  const LineFaultCounts& counts() const { return counts_; }

 private:
  struct Frame {
    Time due;
    Bytes bytes;
  };
  Duration lineTime(std::size_t bytes) const;
  void corrupt(Bytes& frame);
  void insert(Bytes frame, Time due);

  int baud_;
  std::deque<Frame> frames_;  // ascending by due time
  Time line_free_{};
  LineFaults faults_;
  LineFaultCounts counts_;
  std::mt19937 random_;
};

}  // namespace sinew
