#include "sinew/inverse/forward_step.h"

#include <cmath>

#include "sinew/constraint/cable.h"

namespace sinew {
namespace {

VecX minimalEfforts(const RobotModel& robot) {
  VecX efforts(robot.actuatorCount());
  for (int i = 0; i < efforts.size(); ++i) efforts[i] = robot.cables()[i].description().tension.min;
  return efforts;
}

}  // namespace

ForwardStep::ForwardStep(const RobotModel& robot)
    : problem_(minimalEfforts(robot), robot.maxContacts()),
      displacement_(VecX::Zero(robot.actuatorCount())),
      change_(VecX::Zero(robot.actuatorCount())),
      gap_(VecX::Zero(robot.maxContacts())) {}

ForwardStatus ForwardStep::move(const Actuation& actuation, CondensedRobot& robot, VecX& effort, StageTimes& times) {
  QpStatus status;
  {
    const StageTimer timer(times.qp);
    displacement_ = robot.displacement() + robot.freeMotion().head(robot.actuators());
    gap_.head(robot.contacts()) = robot.gap() + robot.freeMotion().tail(robot.contacts());
    status = problem_.solve(robot.compliance(), robot.firstContact(), displacement_, gap_.head(robot.contacts()),
                            effort, actuation);
  }
  change_ = problem_.effortChange();
  if (status != QpStatus::kSolved || !change_.allFinite()) return ForwardStatus::kNotFinite;
  const double scale = robot.advance(change_, problem_.contactForce(), robot.robot().maxNodeStep(), times);
  effort += scale * change_;
  return ForwardStatus::kSolved;
}

ForwardStatus ForwardStep::touchAndMove(const Actuation& actuation, ContactFinder* contacts, CondensedRobot& robot,
                                        VecX& effort, StageTimes& times) {
  if (contacts != nullptr) {
    contacts->find(robot.body().positions(), times);
    robot.addContacts(*contacts);
  }
  robot.condense(times);
  return move(actuation, robot, effort, times);
}

ForwardStatus ForwardStep::step(const Actuation& actuation, const StepRule& rule, ContactFinder* contacts,
                                CondensedRobot& robot, VecX& effort, StageTimes& times) {
  robot.body().beginStep();
  robot.linearise(effort, rule, times);
  const ForwardStatus status = robot.factorise(times) ? touchAndMove(actuation, contacts, robot, effort, times)
                                                      : ForwardStatus::kNotPositiveDefinite;
  robot.body().endStep(rule);
  return status;
}

ForwardStatus ForwardStep::stepAgain(const Actuation& actuation, ContactFinder* contacts, CondensedRobot& robot,
                                     VecX& effort, StageTimes& times) {
  robot.relinearise(effort, times);
  return touchAndMove(actuation, contacts, robot, effort, times);
}

bool ForwardStep::settled(const Actuation& actuation, double tolerance, const CondensedRobot& robot,
                          const VecX& effort) const {
  if (!(robot.residual() <= tolerance * robot.loadNorm())) return false;
  const double slack = tolerance * effort.cwiseAbs().maxCoeff();
  for (int i = 0; i < robot.actuators(); ++i) {
    const Cable& cable = robot.robot().cables()[i];
    const double excess = robot.displacement()[i] - actuation.value[i];
    const bool taut = effort[i] > cable.description().tension.min + slack;
    if (actuation.mode[i] == Actuation::Mode::kEffort) {
      if (effort[i] != actuation.value[i]) return false;
    } else if (!((taut ? std::abs(excess) : -excess) <= tolerance * cable.restLength())) {
      return false;
    }
  }
  return true;
}

ForwardStatus ForwardStep::settle(const Actuation& actuation, double tolerance, int max_steps, ContactFinder* contacts,
                                  CondensedRobot& robot, VecX& effort, StageTimes& times) {
  const StepRule rule;
  robot.body().beginStep();
  for (int k = 0; k < max_steps; ++k) {
    robot.linearise(effort, rule, times);
    if (settled(actuation, tolerance, robot, effort)) {
      robot.body().endStep(rule);
      return ForwardStatus::kSolved;
    }
    if (!std::isfinite(robot.residual())) return ForwardStatus::kNotFinite;
    if (!robot.factorise(times)) return ForwardStatus::kNotPositiveDefinite;
    const ForwardStatus status = touchAndMove(actuation, contacts, robot, effort, times);
    if (status != ForwardStatus::kSolved) return status;
  }
  return ForwardStatus::kNotConverged;
}

}  // namespace sinew
