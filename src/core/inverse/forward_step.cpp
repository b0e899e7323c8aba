#include "sinew/inverse/forward_step.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

VecX minimalEfforts(const RobotModel& robot) {
  VecX efforts(robot.actuatorCount());
  for (int i = 0; i < efforts.size(); ++i) {
    const bool carrier = robot.hasCarrier() && i + 1 == efforts.size();
    efforts[i] = carrier ? -kUnlimited : robot.actuators()[i].effort.min;  // it pushes as well as it pulls
  }
  return efforts;
}

}  // namespace

ForwardStep::ForwardStep(const RobotModel& robot)
    : problem_(minimalEfforts(robot), robot.maxContacts()),
      displacement_(VecX::Zero(robot.actuatorCount())),
      change_(VecX::Zero(robot.actuatorCount())),
      gap_(VecX::Zero(robot.maxContacts())),
      guess_(VecX::Zero(robot.maxContacts())) {
  last_forces_.reserve(static_cast<std::size_t>(robot.maxContacts()));
}

// The forces of the last step's contacts that are still there; both lists are sorted by key.
void ForwardStep::recall(const ContactList& contacts) {
  auto last = last_forces_.begin();
  for (int i = 0; i < contacts.size(); ++i) {
    const std::uint64_t key = contacts.row(i).key;
    while (last != last_forces_.end() && last->key < key) ++last;
    guess_[i] = last != last_forces_.end() && last->key == key ? last->force : 0;
  }
}

void ForwardStep::remember(const ContactList& contacts) {
  last_forces_.clear();
  for (int i = 0; i < contacts.size(); ++i) {
    if (contactForce()[i] > 0) last_forces_.push_back({contacts.row(i).key, contactForce()[i]});
  }
}

ForwardStatus ForwardStep::move(const Actuation& actuation, CondensedRobot& robot, VecX& effort, StageTimes& times) {
  QpStatus status;
  {
    const StageTimer timer(times.qp);
    displacement_ = robot.displacement() + robot.freeMotion().head(robot.actuators());
    gap_.head(robot.contacts()) = robot.gap() + robot.freeMotion().tail(robot.contacts());
    status = problem_.solve(robot.compliance(), robot.firstContact(), displacement_, gap_.head(robot.contacts()),
                            effort, actuation, guess_.head(robot.contacts()));
  }
  change_ = problem_.effortChange();
  if (status != QpStatus::kSolved || !change_.allFinite()) return ForwardStatus::kNotFinite;
  const double scale = robot.advance(change_, problem_.contactForce(), robot.robot().maxNodeStep(), times);
  robot.updateEffort(change_, problem_.contactForce(), scale, effort);
  return ForwardStatus::kSolved;
}

ForwardStatus ForwardStep::touchAndMove(const Actuation& actuation, ContactFinder* contacts, CondensedRobot& robot,
                                        VecX& effort, StageTimes& times) {
  if (contacts != nullptr) {
    contacts->find(robot.positions(), times);
    robot.addContacts(*contacts);
    recall(contacts->list());
  }
  robot.condense(times);
  const ForwardStatus status = move(actuation, robot, effort, times);
  if (contacts != nullptr && status == ForwardStatus::kSolved) remember(contacts->list());
  return status;
}

ForwardStatus ForwardStep::step(const Actuation& actuation, const StepRule& rule, ContactFinder* contacts,
                                CondensedRobot& robot, VecX& effort, StageTimes& times) {
  robot.beginStep();
  if (rule.dynamic && robot.robot().hasCarrier()) robot.accelerateCarrier(actuation.value[robot.actuators() - 1], rule);
  robot.linearise(effort, rule, times);
  const ForwardStatus status = robot.factorise(times) ? touchAndMove(actuation, contacts, robot, effort, times)
                                                      : ForwardStatus::kNotPositiveDefinite;
  robot.endStep(rule);
  return status;
}

ForwardStatus ForwardStep::stepAgain(const Actuation& actuation, ContactFinder* contacts, CondensedRobot& robot,
                                     VecX& effort, StageTimes& times) {
  robot.relinearise(effort, times);
  return touchAndMove(actuation, contacts, robot, effort, times);
}

bool ForwardStep::settled(const Actuation& actuation, double tolerance, const CondensedRobot& robot,
                          const VecX& effort) const {
  if (!(robot.residual() <= std::max(tolerance * robot.loadNorm(), robot.roundingForce()))) return false;
  const double slack = tolerance * effort.cwiseAbs().maxCoeff();
  for (int i = 0; i < robot.actuators(); ++i) {
    const double excess = robot.displacement()[i] - actuation.value[i];
    const bool taut = effort[i] > problem_.effortMin()[i] + slack;
    if (actuation.mode[i] == Actuation::Mode::kEffort) {
      if (effort[i] != actuation.value[i]) return false;
    } else if (!((taut ? std::abs(excess) : -excess) <= tolerance * robot.robot().actuatorLength(i))) {
      return false;
    }
  }
  return true;
}

ForwardStatus ForwardStep::settle(const Actuation& actuation, double tolerance, int max_steps, ContactFinder* contacts,
                                  CondensedRobot& robot, VecX& effort, StageTimes& times) {
  const StepRule rule;
  robot.beginStep();
  for (int k = 0; k < max_steps; ++k) {
    robot.linearise(effort, rule, times);
    if (settled(actuation, tolerance, robot, effort)) {
      robot.endStep(rule);
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
