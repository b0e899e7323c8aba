#pragma once

#include <array>
#include <cstdint>

#include "deadline_statistics.h"
#include "ros_conversions.h"

namespace sinew {

/// What the diagnostics say of the cycles.
struct ControlSummary {
  std::uint8_t status = ControllerState::DISABLED;
  const char* reason = "";
  std::uint64_t cycle = 0;
  std::array<std::uint64_t, 4> held{};         ///< cycles held, by HoldReason; none: for a lost obstacle
  double median = 0, maximum = 0;              ///< s, of a whole cycle over the last second
  std::uint64_t misses = 0;                    ///< deadlines
  double worst_answer = 0, recent_answer = 0;  ///< s from when a cycle was due to its command; 99 % of the last second
  OverloadLevel level = OverloadLevel::kNone;
  std::array<std::uint64_t, kOverloadLevels> levels{};  ///< cycles at each
  std::uint64_t unsent = 0;                             ///< commands that found no room on their way out
};

}  // namespace sinew
