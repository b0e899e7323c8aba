#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sinew/hardware/actuator_reading.h"
#include "sinew/hardware/byte_stream.h"

namespace sinew {

constexpr std::size_t kMaxActuators = 32;

enum class CommandStatus : std::uint8_t { kOk = 0, kDegraded = 1, kHeld = 2 };

enum class CommandVerdict : std::uint8_t {
  kAccepted,
  kMalformed,  ///< wrong sizes, unknown or duplicate names, wrong mode or status
  kNotFinite,
  kSession,   ///< of another session than the one that is locked
  kSequence,  ///< repeated or out of order
  kState      ///< the driver takes no such command now
};

/// Set points as they arrived, brought into the driver's order. Trivially copyable: it crosses threads.
struct Command {
  CommandVerdict defect =
      CommandVerdict::kMalformed;  ///< what is wrong with the message itself; kAccepted when nothing
  CommandStatus status = CommandStatus::kOk;
  std::uint32_t session = 0;
  std::uint32_t sequence = 0;
  Time received{};
  std::array<double, kMaxActuators> value{};   ///< m or Pa, in the driver's order
  std::array<double, kMaxActuators> effort{};  ///< N that each is expected to carry; not a number where nothing is said
};

/// Brings messages into the driver's order and finds what is wrong with them. Stateless, so any thread may read.
class CommandReader {
 public:
  /// Throws ConfigError for more than kMaxActuators names.
  CommandReader(std::vector<std::string> names, std::vector<Quantity> quantities);

  /// A message must name every actuator exactly once, in its own quantity, with a finite value each. `efforts` is
  /// empty, or gives one per name.
  Command read(std::uint32_t session, std::uint32_t sequence, std::uint8_t status,
               const std::vector<std::string>& names, const std::vector<std::uint8_t>& modes,
               const std::vector<double>& values, const std::vector<double>& efforts, Time received) const;

 private:
  std::vector<std::string> names_;
  std::vector<Quantity> quantities_;
};

/// Who may command. Locks to the first session that is accepted and stays with it until `release()`; within a session
/// the sequence must rise. Counts what it refuses, by reason. Ages are by the clock of the times given, never by
/// stamps.
class CommandGate {
 public:
  struct Counters {
    std::uint64_t accepted = 0, session = 0, sequence = 0, malformed = 0, not_finite = 0, state = 0;
  };

  /// The verdict on `command` from its own defects, its session and its sequence; changes nothing.
  CommandVerdict check(const Command& command) const;
  void accept(const Command& command);
  void refuse(CommandVerdict reason);
  /// Forgets the session: the next may be any.
  void release();

  bool locked() const { return locked_; }
  std::uint32_t session() const { return locked_ ? session_ : 0; }
  std::uint32_t sequence() const { return sequence_; }
  /// Seconds since the last accepted command, -1 before the first.
  double age(Time now) const;
  const Counters& counters() const { return counters_; }

 private:
  bool locked_ = false, any_ = false;
  std::uint32_t session_ = 0, sequence_ = 0;
  Time received_{};
  Counters counters_;
};

}  // namespace sinew
