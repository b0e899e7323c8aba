#include "sinew/inverse/linearisation.h"

#include <cmath>

namespace sinew {

Linearisation::Linearisation(const std::shared_ptr<const RobotModel>& robot)
    : condensed(robot), finder(*robot), effort(VecX::Zero(robot->actuatorCount())) {}

void Linearisation::begin(const VecX& present_effort) {
  effort = present_effort;
  answers = repeats = false;
  age = 0;
}

HoldReason Linearisation::factorise(StageTimes& times) {
  condensed.linearise(effort, StepRule(), times);
  if (!std::isfinite(condensed.residual())) return HoldReason::kNotFinite;
  return condensed.factorise(times) ? HoldReason::kNone : HoldReason::kNotPositiveDefinite;
}

void Linearisation::condense(StageTimes& times) {
  if (finder.active()) {
    finder.find(condensed.positions(), times);
    condensed.addContacts(finder);
  }
  condensed.condense(times);
  answers = true;
}

void Linearisation::recall() {
  condensed.abandonStep();
  condensed.shiftGaps(finder);
}

}  // namespace sinew
