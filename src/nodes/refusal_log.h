#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <string>

namespace sinew {

/// Why a message is refused as a whole.
enum class RefusalReason {
  kWrongSize,
  kUnknownName,
  kDuplicateName,
  kNotFinite,
  kUnknownFrame,
  kStamp,
  kJump,
  kMode,
  kNotTracked,
  kOrientation
};
constexpr std::size_t kRefusalReasons = 10;

/// The reason as a word of the diagnostics: `not_finite`.
const char* nameOf(RefusalReason reason);

struct Refusal {
  RefusalReason reason;
  std::string words;
};

/// Counts refusals by reason and keeps the last one in words. Any thread, but not the cycle's.
class RefusalLog {
 public:
  using Counts = std::array<std::uint64_t, kRefusalReasons>;

  void add(const Refusal& refusal) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++counts_[static_cast<std::size_t>(refusal.reason)];
    ++total_;
    last_ = refusal.words;
  }

  Counts counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
  }

  std::uint64_t total() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return total_;
  }

  std::string last() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return last_;
  }

 private:
  mutable std::mutex mutex_;
  Counts counts_{};
  std::uint64_t total_ = 0;
  std::string last_;
};

}  // namespace sinew
