#pragma once

#include <memory>

#include "sinew/inverse/condensed_robot.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/forward_step.h"

namespace sinew {

/// The body of a dynamic robot: it follows the commanded displacements with inertia and damping, apart from the plan.
/// Planning about the moving state instead would make the settled answer depend on the period, since A^-1 then decides
/// over the actuators' redundancy, and lets vibrations into the commands.
struct MovingBody {
  explicit MovingBody(const std::shared_ptr<const RobotModel>& robot);

  /// To `displacement` [m, per actuator] within `period` [s].
  ForwardStatus follow(const VecX& displacement, double period, StageTimes& times);
  /// At rest in the configuration of `other`, with efforts [N].
  void place(const CondensedRobot& other, const VecX& new_effort);

  CondensedRobot condensed;
  ContactFinder finder;
  ForwardStep forward;
  Actuation winches;
  VecX effort;
};

}  // namespace sinew
