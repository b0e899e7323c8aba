#pragma once

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// Reads and writes of a non-blocking descriptor with the meaning of ByteStream.
StreamResult readDescriptor(int fd, std::uint8_t* data, std::size_t capacity, Duration timeout);
StreamResult writeDescriptor(int fd, const std::uint8_t* data, std::size_t size, Duration timeout);

/// Raw 8N1 without flow control, at `baud`. Returns false with errno set.
bool makeRaw(int fd, int baud);

}  // namespace sinew
