#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ros_conversions.h"

namespace sinew {

/// A command as the cycle decided on it.
struct CommandRecord {
  std::uint32_t session = 0, sequence = 0;
  CycleStatus status = CycleStatus::kHeld;
  VecX displacement;  ///< m
  VecX effort;        ///< N that the model expects with it; not a number where it does not know
};

/// Which message a cycle used.
struct InputReference {
  const std::string* topic = nullptr;
  MessageStamp source;
};

/// What a cycle did, for whoever reports it. Sized at set-up.
struct CycleRecord {
  std::uint8_t status = ControllerState::DISABLED;
  const char* reason = "";
  std::uint32_t session = 0, sequence = 0;  ///< 0 while disabled
  std::uint64_t cycle = 0;
  double period = 0;          ///< s, from the start of the cycle before
  double answered = 0;        ///< s after the cycle was due to begin, when its command was handed over
  std::uint64_t skipped = 0;  ///< periods left out since the start
  bool modelled = false;      ///< whether `targets` and `output` are of this cycle
  VecX targets;               ///< m
  std::vector<bool> targeted;
  CycleOutput output;
  std::array<double, kStages> durations{};  ///< s
  std::vector<InputReference> inputs;       ///< the leading `input_count` count
  std::size_t input_count = 0;

  /// Adds a message that is not there yet.
  void addInput(const std::string& topic, const MessageStamp& source);
};

CommandRecord makeCommandRecord(const RobotModel& robot);
CycleRecord makeCycleRecord(const RobotModel& robot, const CycleInput& input, const CycleOutput& output);

}  // namespace sinew
