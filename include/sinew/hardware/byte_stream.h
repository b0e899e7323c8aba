#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sinew {

/// Time of the hardware layer. A port takes it from the steady clock, a simulated line from its own virtual clock; both
/// count from their clock's epoch, so that ages and deadlines never see the host's wall clock.
using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
using Duration = std::chrono::nanoseconds;

/// Seconds of a duration.
inline double seconds(Duration d) {
  return 1e-9 * static_cast<double>(d.count());
}
/// The duration of `s` seconds, to the nanosecond.
inline Duration duration(double s) {
  return Duration(static_cast<std::int64_t>(s * 1e9));
}

enum class StreamStatus {
  kOk,       ///< at least one byte went through
  kTimeout,  ///< none within the given time
  kClosed    ///< not open, unplugged or hung up: nothing will ever go through again until it is reopened
};

struct StreamResult {
  StreamStatus status = StreamStatus::kClosed;
  std::size_t count = 0;  ///< bytes that went through
};

/// A line of bytes in both directions. No call blocks for longer than the time it is given.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  /// Reads what has arrived, at most `capacity` bytes; waits up to `timeout` for the first one.
  virtual StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) = 0;

  /// Writes `size` bytes, waiting up to `timeout` for room; kTimeout with a smaller count when only a part fitted.
  virtual StreamResult write(const std::uint8_t* data, std::size_t size, Duration timeout) = 0;

  /// Now, by the clock that the timeouts of this stream run on.
  virtual Time now() const { return Clock::now(); }
};

}  // namespace sinew
