#pragma once

#include <memory>
#include <string>
#include <vector>

#include "duration_sample.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

/// What cycles of a robot take on this machine.
struct CycleTiming {
  enum Stage { kAssembly, kFactor, kDetection, kCompliance, kQp, kAdvance, kStageCount };
  static const char* nameOf(int stage);

  std::vector<DurationSample> stages{kStageCount};
  DurationSample cycle;        ///< of the whole
  DurationSample sharedCycle;  ///< of one that shares the linearisation of an earlier one, as under overload
  int contacts = 0;            ///< the most in a cycle
  int held = 0;                ///< cycles that were not solved
  bool rests = true;           ///< whether there is an equilibrium with slack cables

  /// Hz at which 99 % of the cycles leave a quarter of their period free, at most what the controller's node takes.
  double predictRate() const;
  /// The same where cycles share linearisations.
  double predictSharedRate() const;
  /// s that a cycle may take for that at a rate [Hz].
  static double calcLongest(double rate);
  /// Share of the cycle that a stage takes, by medians.
  double shareOf(int stage) const;
};

/// Times the controller while its first effector is led round a small circle about its place of rest, with the
/// obstacles where they are.
CycleTiming timeCycles(std::shared_ptr<const RobotModel> robot, int cycles);

}  // namespace sinew
