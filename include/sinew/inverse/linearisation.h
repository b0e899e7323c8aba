#pragma once

#include <memory>

#include "sinew/inverse/condensed_robot.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/cycle.h"

namespace sinew {

/// The robot linearised where it stood, and condensed to its constraints with the contacts that it had there. A cycle
/// answers with one; while time is short several answer with the same.
struct Linearisation {
  explicit Linearisation(const std::shared_ptr<const RobotModel>& robot);

  /// To be made anew with `present_effort` [N].
  void begin(const VecX& present_effort);
  HoldReason factorise(StageTimes& times);
  void condense(StageTimes& times);
  /// To where the linear problem holds; only the obstacles have moved on.
  void recall();

  CondensedRobot condensed;
  ContactFinder finder;
  VecX effort;           ///< N, total, that it was linearised with
  bool answers = false;  ///< condensed, in the configuration in which the present step began
  bool repeats = false;  ///< has answered a cycle
  int age = 0;           ///< cycles
};

}  // namespace sinew
