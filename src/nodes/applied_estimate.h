#pragma once

#include <array>
#include <cstdint>

#include "sinew/common/types.h"

namespace sinew {

/// What the driver has applied by now, from the commands sent and its reports, which lag behind by some cycles. A
/// report that repeats its command leaves the newest command as the estimate: latency alone never slows the controller
/// down. An actuator that the driver held back is taken to move on, from where the report saw it, no faster than it did
/// then and only as far as the commands since: no wind-up, and no correction counted twice. Never allocates after
/// set-up.
class AppliedEstimate {
 public:
  explicit AppliedEstimate(int actuators);

  /// Forgets commands and reports; the estimate is `applied` [m].
  void reset(const VecX& applied);
  /// Displacements [m] sent with `sequence`, which is one more than that of the command before.
  void addCommand(std::uint32_t sequence, const VecX& displacement);
  /// Displacements [m] that the driver applied for command `sequence`; reports on unknown commands are ignored.
  void addReport(std::uint32_t sequence, const VecX& applied);

  const VecX& applied() const { return estimate_; }  ///< m, per actuator

 private:
  static constexpr std::uint32_t kHistory = 64;  // commands
  static constexpr double kSame = 1e-6;          // m, a report this near its command repeats it

  void updateEstimate();
  bool knows(std::uint32_t sequence) const;
  const VecX& command(std::uint32_t sequence) const { return commands_[sequence % kHistory]; }

  std::array<VecX, kHistory> commands_;
  std::uint32_t sent_ = 0;    // commands since reset
  std::uint32_t newest_ = 0;  // sequence of the newest command
  bool reported_ = false;
  std::uint32_t report_sequence_ = 0;
  VecX report_;  // m, newest report
  VecX speed_;   // m per command, as the driver moved up to the newest report
  VecX estimate_;
};

}  // namespace sinew
