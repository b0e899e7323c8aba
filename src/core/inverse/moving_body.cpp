#include "sinew/inverse/moving_body.h"

namespace sinew {

MovingBody::MovingBody(const std::shared_ptr<const RobotModel>& robot)
    : condensed(robot), finder(*robot), forward(*robot), effort(VecX::Zero(robot->actuatorCount())) {
  winches.mode.assign(static_cast<std::size_t>(robot->actuatorCount()), Actuation::Mode::kDisplacement);
  winches.value = VecX::Zero(robot->actuatorCount());
}

ForwardStatus MovingBody::follow(const VecX& displacement, double period, StageTimes& times) {
  winches.value = displacement;
  const ForwardStatus status =
      forward.step(winches, condensed.makeRule(period), finder.activeOrNull(), condensed, effort, times);
  if (status != ForwardStatus::kSolved) condensed.abandonStep();
  return status;
}

void MovingBody::place(const CondensedRobot& other, const VecX& new_effort) {
  condensed.place(other);
  effort = new_effort;
}

}  // namespace sinew
