#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sinew {

// Consistent overhead byte stuffing ("Consistent Overhead Byte Stuffing", IEEE/ACM Transactions on Networking 7(2),
// 1999): data without zeros, so that a zero can end a frame.

/// Appends `data` without its zeros, and without an ending zero, to `out`: at most size + size / 254 + 1 bytes.
void appendCobs(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& out);

/// Puts the zeros back into a frame that came without its ending zero. False when no data give such a frame; `out` is
/// then of no use.
bool decodeCobs(const std::uint8_t* data, std::size_t size, std::vector<std::uint8_t>& out);

}  // namespace sinew
