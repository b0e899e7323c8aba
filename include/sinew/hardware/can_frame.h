#pragma once

#include <array>
#include <cstdint>

namespace sinew {

/// A classic CAN frame.
struct CanFrame {
  std::uint32_t id = 0;  ///< 11 bits, or 29 when extended
  bool extended = false;
  bool remote = false;    ///< a request without data; `size` is the length asked for
  std::uint8_t size = 0;  ///< bytes of data, 0 to 8
  std::array<std::uint8_t, 8> data{};
};

}  // namespace sinew
