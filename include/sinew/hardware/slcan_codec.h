#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sinew/hardware/can_frame.h"

namespace sinew {

/// The longest frame in the ASCII protocol of LAWICEL's serial CAN adapters: T, 8 digits of identifier, length, 16
/// digits of data, 4 of a time stamp, carriage return.
constexpr std::size_t kMaxSlcanLine = 1 + 8 + 1 + 16 + 4 + 1;

/// Writes the command that sends `frame` into `out`, of kMaxSlcanLine bytes at least; returns its size.
///   tiiiLdd..  data frame with 11 bits of identifier, Tiiiiiiii.. with 29; r and R likewise for remote frames
std::size_t encodeSlcan(const CanFrame& frame, std::uint8_t* out);

enum class SlcanEvent {
  kNone,    ///< the line goes on
  kFrame,   ///< a CAN frame has come
  kOk,      ///< the adapter did as it was told
  kError,   ///< the adapter refuses
  kInfo,    ///< an answer to a question, e.g. of version or status
  kDamaged  ///< a line that means nothing, or too long to mean anything
};

/// Takes what an adapter sends, byte by byte. A time stamp behind a frame is accepted and left alone.
class SlcanDecoder {
 public:
  SlcanEvent put(std::uint8_t byte);
  /// After kFrame.
  const CanFrame& frame() const { return frame_; }

 private:
  SlcanEvent endLine();
  bool readFrame();

  std::array<std::uint8_t, kMaxSlcanLine> line_{};
  std::size_t size_ = 0;
  bool too_long_ = false;
  CanFrame frame_;
};

}  // namespace sinew
