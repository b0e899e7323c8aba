#pragma once

#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/can_frame.h"

namespace sinew {

/// A node's access to a CAN bus. No call blocks for longer than the time it is given.
class CanPort {
 public:
  virtual ~CanPort() = default;

  /// Queues a frame; kTimeout when there was no room for it.
  virtual StreamStatus send(const CanFrame& frame, Duration timeout) = 0;
  /// The next frame that others have sent; waits up to `timeout` for one.
  virtual StreamStatus receive(CanFrame& frame, Duration timeout) = 0;

  /// What came damaged, was lost on its way to the caller, or was refused by the port's adapter, since it was opened.
  virtual std::uint64_t damaged() const { return 0; }

  /// Now, by the clock that the timeouts of this port run on.
  virtual Time now() const { return Clock::now(); }
};

}  // namespace sinew
