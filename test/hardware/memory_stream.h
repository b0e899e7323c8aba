#pragma once

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// A line whose other end is the test: remembers what is written, and answers what it was told to. Its clock moves only
/// while someone waits.
class MemoryStream : public ByteStream {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Bytes that arrive as soon as the next write is done.
  void answerNextWrite(const Bytes& bytes) { answer_ = bytes; }
  /// Bytes that have arrived already.
  void arrive(const Bytes& bytes) { arrived_.insert(arrived_.end(), bytes.begin(), bytes.end()); }
  Bytes takeWritten() { return std::exchange(written_, {}); }

  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) override {
    const std::size_t count = std::min(capacity, arrived_.size());
    if (count == 0) {
      now_ += timeout;
      return {StreamStatus::kTimeout, 0};
    }
    std::copy(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(count), data);
    arrived_.erase(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(count));
    return {StreamStatus::kOk, count};
  }

  StreamResult write(const std::uint8_t* data, std::size_t size, Duration) override {
    written_.insert(written_.end(), data, data + size);
    arrive(std::exchange(answer_, {}));
    return {StreamStatus::kOk, size};
  }

  Time now() const override { return now_; }

 private:
  std::deque<std::uint8_t> arrived_;
  Bytes written_, answer_;
  Time now_{std::chrono::seconds(1)};
};

}  // namespace sinew
