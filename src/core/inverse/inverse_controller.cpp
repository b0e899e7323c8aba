#include "sinew/inverse/inverse_controller.h"

#include <algorithm>
#include <cmath>

#include "sinew/constraint/point_effector.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/cycle_plan.h"
#include "sinew/inverse/forward_step.h"
#include "sinew/inverse/linearisation.h"
#include "sinew/inverse/moving_body.h"

namespace sinew {
namespace {

constexpr double kSyncStep = 5e-3;  // m of cable per load step when the model is moved to a measurement
constexpr double kSyncTolerance = 1e-9;
constexpr int kSyncIterations = 100;

constexpr double kOnLimit = 1e-9;  // of the range, within which a limit counts as reached

HoldReason reasonOf(ForwardStatus status) {
  switch (status) {
    case ForwardStatus::kSolved:
      return HoldReason::kNone;
    case ForwardStatus::kNotPositiveDefinite:
      return HoldReason::kNotPositiveDefinite;
    default:
      return HoldReason::kNotFinite;
  }
}

// What the parts of a cycle add to or may not come to.
void clearReport(CycleOutput& output) {
  output.times = StageTimes();
  output.qp_iterations = output.newton_steps = 0;
  output.contacts.pieces = output.contacts.nodes = 0;
  output.contacts.proved_global = output.contacts.declined_better = output.contacts.out_of_time = false;
  output.contacts.crowded = false;
  output.goal_scale = 1;
  output.holds = true;
  output.repeats = false;
  output.linearisation_age = 0;
}

}  // namespace

struct InverseController::Impl {
  std::shared_ptr<const RobotModel> robot;
  std::unique_ptr<Linearisation> now;
  std::unique_ptr<Linearisation> spare;  // being renewed
  std::unique_ptr<MovingBody> moving;    // of a dynamic robot
  bool moving_waits = false;             // for want of time: the plan is shown in its place
  ForwardStep forward;
  CyclePlan plan;
  CycleLimits limits;
  Actuation held;
  VecX effort;               // N, total
  VecX command;              // m, of the last cycle
  VecX cycle_start;          // m, what the rates of this cycle count from
  VecX linear_displacement;  // m, actuators as the linear problem moves them
  VecX last_valid_effort;
  bool prepared = false;  // `now` holds the factor of the next step
  bool renewing = false;  // `spare` is to take its place

  explicit Impl(std::shared_ptr<const RobotModel> model)
      : robot(model),
        now(std::make_unique<Linearisation>(model)),
        forward(*model),
        plan(*model),
        limits(model->actuatorCount()),
        effort(VecX::Zero(model->actuatorCount())),
        command(VecX::Zero(model->actuatorCount())),
        cycle_start(VecX::Zero(model->actuatorCount())),
        linear_displacement(VecX::Zero(model->actuatorCount())),
        last_valid_effort(VecX::Zero(model->actuatorCount())) {
    held.mode.assign(static_cast<std::size_t>(actuators()), Actuation::Mode::kDisplacement);
    held.value = VecX::Zero(actuators());
    if (model->description().control.model == MotionModel::kDynamic) moving = std::make_unique<MovingBody>(model);
  }

  const CondensedRobot& shown() const { return moving && !moving_waits ? moving->condensed : now->condensed; }
  const std::vector<Vec3>& positions() const { return shown().positions(); }

  int actuators() const { return robot->actuatorCount(); }
  const Limits& displacementLimits(int i) const { return robot->actuators()[i].displacement; }
  const Limits& effortLimits(int i) const { return robot->actuators()[i].effort; }

  bool validInput(const CycleInput& input) const {
    return input.targets.size() == 3 * robot->effectorCount() &&
           static_cast<int>(input.targeted.size()) == robot->effectorCount() &&
           (input.applied.size() == 0 || input.applied.size() == actuators()) && input.applied.allFinite() &&
           (input.by_hand.size() == 0 || input.by_hand.size() == actuators()) && !input.by_hand.array().isInf().any() &&
           std::isfinite(input.period) && input.period > 0;
  }

  static bool givenByHand(const CycleInput& input, int i) {
    return input.by_hand.size() > 0 && !std::isnan(input.by_hand[i]);
  }

  // A rate is hard: outside the range the command comes back no faster than the rate allows. What somebody else gives
  // an actuator knows neither.
  void updateLimits(const CycleInput& input) {
    const double period = input.period;
    for (int i = 0; i < actuators(); ++i) {
      const Limits& range = displacementLimits(i);
      const double step = range.rate * period;
      limits.displacement_min[i] = std::min(std::max(range.min, cycle_start[i] - step), cycle_start[i] + step);
      limits.displacement_max[i] = std::max(std::min(range.max, cycle_start[i] + step), cycle_start[i] - step);
      const Limits& effort_range = effortLimits(i);
      const double change = effort_range.rate * period;
      limits.effort_min[i] = std::max(effort_range.min, last_valid_effort[i] - change);
      limits.effort_max[i] = std::min(effort_range.max, last_valid_effort[i] + change);
      limits.effort_min[i] = std::min(limits.effort_min[i], limits.effort_max[i]);
      if (givenByHand(input, i)) limits.displacement_min[i] = limits.displacement_max[i] = input.by_hand[i];
    }
  }

  HoldReason factorise(StageTimes& times) {
    renewing = false;
    now->begin(effort);
    return now->factorise(times);
  }

  HoldReason linearise(StageTimes& times) {
    const HoldReason reason = prepared ? HoldReason::kNone : factorise(times);
    prepared = false;
    now->age = 0;
    if (reason == HoldReason::kNone) now->condense(times);
    return reason;
  }

  bool sharesLinearisation(const CycleInput& input) const {
    return input.overload == OverloadLevel::kSharedLinearisation && now->answers;
  }

  void recallLinearisation(CycleOutput& output) {
    now->recall();
    effort = now->effort;
    output.repeats = now->repeats;
    output.linearisation_age = now->age;
  }

  HoldReason answer(const CycleInput& input, CycleOutput& output) {
    HoldReason reason;
    {
      const StageTimer timer(output.times.qp);
      reason = plan.make(now->condensed, now->finder, input, limits, effort, output);
    }
    if (reason != HoldReason::kNone) return reason;

    const double scale =
        now->condensed.advance(plan.effortChange(), plan.contactForce(), robot->maxNodeStep(), output.times);
    now->condensed.updateEffort(plan.effortChange(), plan.contactForce(), scale, effort);
    if (!output.repeats) plan.recordStep(scale);
    now->repeats = true;
    linear_displacement = now->condensed.displacement() + scale * plan.actuatorMotion();
    output.contacts.force.head(now->condensed.contacts()) = plan.contactForce();
    output.contacts.gap.head(now->condensed.contacts()) = plan.contactGap();
    return linear_displacement.allFinite() && effort.allFinite() ? HoldReason::kNone : HoldReason::kNotFinite;
  }

  void reportState(const CycleInput& input, CycleOutput& output) {
    double squared = 0;
    for (int e = 0; e < robot->effectorCount(); ++e) {
      const PointEffector& effector = robot->effectors()[e];
      output.effectors.segment<3>(3 * e) = effector.calcPosition(positions());
      if (!input.targeted[e]) continue;
      double error[3];
      effector.calcError(positions(), input.targets.segment<3>(3 * e), error);
      for (int k = 0; k < effector.rowCount(); ++k) squared += error[k] * error[k];
    }
    output.effector_error = std::sqrt(squared);
    output.residual = now->condensed.residual();
    output.residual_relative = output.residual / std::max(now->condensed.loadNorm(), 1e-300);
    output.displacement = command;
    output.effort = effort;
    output.contacts.count = now->finder.list().size();
  }

  void reportLimits(CycleOutput& output) {
    output.limits.clear();
    const auto report = [&](int actuator, LimitKind kind, double value, double violation) {
      if (output.limits.size() < output.limits.capacity()) output.limits.push_back({actuator, kind, value, violation});
    };
    for (int i = 0; i < actuators(); ++i) {
      const Limits& range = displacementLimits(i);
      const double low = limits.displacement_min[i], high = limits.displacement_max[i];
      const double near = kOnLimit * std::max(high - low, 1e-6);
      const bool given = low == high && low != range.min && low != range.max;
      if (!given && command[i] - low <= near) {
        report(i, low == range.min ? LimitKind::kDisplacementMin : LimitKind::kRateMin,
               low == range.min ? range.min : range.rate, 0);
      }
      if (!given && high - command[i] <= near) {
        report(i, high == range.max ? LimitKind::kDisplacementMax : LimitKind::kRateMax,
               high == range.max ? range.max : range.rate, 0);
      }
      const Limits& effort_range = effortLimits(i);
      const double span = std::isfinite(effort_range.max) ? effort_range.max - std::max(effort_range.min, 0.0) : 1.0;
      if (effort[i] - effort_range.min <= kOnLimit * span) {
        report(i, LimitKind::kEffortMin, effort_range.min, std::max(0.0, effort_range.min - effort[i]));
      }
      if (effort_range.max - effort[i] <= kOnLimit * span) {
        report(i, LimitKind::kEffortMax, effort_range.max, std::max(0.0, effort[i] - effort_range.max));
      }
    }
  }

  // The model stands still with its cables held, and the command repeats the last valid one.
  CycleStatus hold(const CycleInput& input, HoldReason reason, CycleOutput& output) {
    effort = sharesLinearisation(input) ? now->effort : last_valid_effort;
    output.status = CycleStatus::kHeld;
    output.reason = reason;
    reportState(input, output);
    reportLimits(output);
    return output.status;
  }

  void countAge() {
    ++now->age;
    if (renewing) ++spare->age;
  }

  bool anyTarget(const CycleInput& input) const {
    return std::find(input.targeted.begin(), input.targeted.end(), true) != input.targeted.end();
  }

  // Ends a cycle whose plan stands: the dynamic body, where there is one, goes after the command.
  CycleStatus finish(const CycleInput& input, CycleStatus status, CycleOutput& output) {
    if (moving) {
      const ForwardStatus moved = moveBody(input, output);
      if (moved != ForwardStatus::kSolved) return hold(input, reasonOf(moved), output);
    }
    output.status =
        status == CycleStatus::kSolved && input.overload != OverloadLevel::kNone ? CycleStatus::kDegraded : status;
    output.reason = HoldReason::kNone;
    reportState(input, output);
    reportLimits(output);
    return output.status;
  }

  // Waiting, it is where the plan is when its time comes, and at rest.
  ForwardStatus moveBody(const CycleInput& input, CycleOutput& output) {
    const bool waited = moving_waits;
    moving_waits = input.overload == OverloadLevel::kSharedLinearisation;
    if (moving_waits) return ForwardStatus::kSolved;
    if (waited) moving->place(now->condensed, effort);
    return moving->follow(command, input.period, output.times);
  }

  void see(const std::vector<ObstacleState>& obstacles) {
    now->finder.setObstacles(obstacles);
    if (moving) moving->finder.setObstacles(obstacles);
  }

  HoldReason repeatStep(const CycleInput& input, CycleOutput& output) {
    recallLinearisation(output);
    return answer(input, output);
  }

  HoldReason newtonSteps(const CycleInput& input, CycleOutput& output) {
    const int steps = input.overload == OverloadLevel::kNone ? robot->description().control.newton_steps : 1;
    now->condensed.beginStep();
    HoldReason reason = HoldReason::kNone;
    while (output.newton_steps < steps && reason == HoldReason::kNone) {
      reason = linearise(output.times);
      if (reason == HoldReason::kNone) reason = answer(input, output);
      output.newton_steps += reason == HoldReason::kNone;
    }
    now->answers = steps == 1 && reason == HoldReason::kNone;
    return reason;
  }

  CycleStatus track(const CycleInput& input, CycleOutput& output) {
    if (input.applied.size() == actuators()) command = input.applied;
    cycle_start = command;
    last_valid_effort = effort;
    updateLimits(input);
    const HoldReason reason = sharesLinearisation(input) ? repeatStep(input, output) : newtonSteps(input, output);
    if (reason != HoldReason::kNone) {
      now->condensed.abandonStep();
      return hold(input, reason, output);
    }
    output.holds = plan.holds();
    output.contacts.crowded = now->finder.crowded();
    const bool gave_way = plan.effortViolation().maxCoeff() > kOnLimit || !output.holds || output.contacts.crowded;
    // Rounding must not carry a command past a hard limit.
    command = linear_displacement.cwiseMax(limits.displacement_min).cwiseMin(limits.displacement_max);
    return finish(input, gave_way ? CycleStatus::kDegraded : CycleStatus::kSolved, output);
  }

  ForwardStatus repeatForwardStep(CycleOutput& output) {
    recallLinearisation(output);
    now->repeats = true;
    return forward.move(held, now->condensed, effort, output.times);
  }

  ForwardStatus forwardStep(CycleOutput& output) {
    renewing = false;
    now->begin(effort);
    const ForwardStatus status =
        forward.step(held, StepRule(), now->finder.activeOrNull(), now->condensed, effort, output.times);
    now->answers = now->repeats = status == ForwardStatus::kSolved;
    return status;
  }

  void beginRenewal() {
    spare->condensed.imitate(now->condensed);
    spare->finder.setObstacles(now->finder.obstacles());
    spare->begin(effort);
    renewing = true;
  }

  // One that failed leaves its failure to the next step, which linearises by itself.
  void endRenewal() {
    if (!renewing) return;
    renewing = false;
    if (spare->answers) {
      std::swap(now, spare);
    } else {
      now->answers = false;
    }
  }

  CycleStatus follow(const CycleInput& input, const VecX& displacement, CycleOutput& output) {
    if (displacement.size() != actuators() || !displacement.allFinite()) {
      return hold(input, HoldReason::kNotFinite, output);
    }
    prepared = false;
    held.value = displacement;
    for (int i = 0; i < actuators(); ++i) {
      if (givenByHand(input, i)) held.value[i] = input.by_hand[i];
    }
    last_valid_effort = effort;
    cycle_start = held.value;
    updateLimits(input);
    const ForwardStatus status = sharesLinearisation(input) ? repeatForwardStep(output) : forwardStep(output);
    plan.forget();
    output.qp_iterations = forward.qpIterations();
    output.newton_steps = 1;
    output.contacts.force.head(now->condensed.contacts()) = forward.contactForce();
    output.contacts.gap.head(now->condensed.contacts()) = now->condensed.gap();
    if (status != ForwardStatus::kSolved) {
      now->condensed.abandonStep();
      return hold(input, reasonOf(status), output);
    }
    command = held.value;
    return finish(input, CycleStatus::kSolved, output);
  }

  double distanceTo(const VecX& measured) const {
    double worst = 0;
    VecX modelled(actuators());
    now->condensed.calcDisplacement(modelled);
    for (int i = 0; i < actuators(); ++i) {
      const double excess = modelled[i] - measured[i];
      const bool taut = !std::isfinite(forward.effortMin()[i]) ||
                        effort[i] > effortLimits(i).min + kSyncTolerance * effort.cwiseAbs().maxCoeff();
      worst = std::max(worst, taut ? std::abs(excess) : -excess);
    }
    return worst;
  }
};

InverseController::InverseController(std::shared_ptr<const RobotModel> robot)
    : impl_(std::make_unique<Impl>(std::move(robot))) {}

InverseController::~InverseController() = default;

const RobotModel& InverseController::robot() const {
  return *impl_->robot;
}

CycleInput InverseController::makeInput() const {
  CycleInput input;
  input.targets = VecX::Zero(3 * robot().effectorCount());
  input.targeted.assign(static_cast<std::size_t>(robot().effectorCount()), false);
  return input;
}

CycleOutput InverseController::makeOutput() const {
  CycleOutput output;
  const int actuators = robot().actuatorCount();
  output.displacement = output.effort = VecX::Zero(actuators);
  output.effectors = VecX::Zero(3 * robot().effectorCount());
  output.limits.reserve(4 * static_cast<std::size_t>(actuators));
  output.contacts.force = output.contacts.gap = VecX::Zero(robot().maxContacts());
  return output;
}

void InverseController::prepare(CycleOutput& output) {
  const StageTimer timer(output.times.cycle);
  impl_->prepared = impl_->factorise(output.times) == HoldReason::kNone;
}

void InverseController::makeSpare() {
  impl_->spare = std::make_unique<Linearisation>(impl_->robot);
}

void InverseController::beginRenewal() {
  impl_->beginRenewal();
}

void InverseController::renew(StageTimes& times) {
  const StageTimer timer(times.cycle);
  Linearisation& spare = *impl_->spare;
  if (spare.factorise(times) == HoldReason::kNone) spare.condense(times);
}

void InverseController::endRenewal() {
  impl_->endRenewal();
}

CycleStatus InverseController::step(const CycleInput& input, CycleOutput& output) {
  clearReport(output);
  output.overload = input.overload;
  impl_->countAge();
  const StageTimer timer(output.times.cycle);
  if (!impl_->validInput(input)) {
    output.status = CycleStatus::kHeld;
    output.reason = HoldReason::kNotFinite;
    output.displacement = impl_->command;
    output.effort = impl_->effort;
    return output.status;
  }
  impl_->see(input.obstacles);
  if (!impl_->anyTarget(input)) {
    return impl_->follow(input, input.applied.size() > 0 ? input.applied : impl_->command, output);
  }
  return impl_->track(input, output);
}

CycleStatus InverseController::follow(const VecX& displacement, double period, CycleOutput& output) {
  clearReport(output);
  const StageTimer timer(output.times.cycle);
  CycleInput free = makeInput();
  free.period = period;
  return impl_->follow(free, displacement, output);
}

double InverseController::resynchronise(const VecX& measured) {
  Impl& impl = *impl_;
  const double failed = std::numeric_limits<double>::infinity();
  if (measured.size() != impl.actuators() || !measured.allFinite()) return failed;
  impl.prepared = impl.renewing = impl.now->answers = false;
  VecX start(impl.actuators());
  impl.now->condensed.calcDisplacement(start);
  const int steps = 1 + static_cast<int>((measured - start).cwiseAbs().maxCoeff() / kSyncStep);
  StageTimes times;
  for (int k = 1; k <= steps; ++k) {
    impl.held.value = start + (measured - start) * k / steps;
    const double tolerance = k < steps ? 1e-3 : kSyncTolerance;
    if (impl.forward.settle(impl.held, tolerance, kSyncIterations, impl.now->finder.activeOrNull(), impl.now->condensed,
                            impl.effort, times) != ForwardStatus::kSolved) {
      return failed;
    }
  }
  impl.command = measured;
  if (impl.moving) impl.moving->place(impl.now->condensed, impl.effort);
  impl.plan.forget();
  return impl.distanceTo(measured);
}

void InverseController::reset() {
  impl_->prepared = impl_->renewing = impl_->now->answers = false;
  impl_->now->condensed.reset();
  impl_->effort.setZero();
  if (impl_->moving) impl_->moving->place(impl_->now->condensed, impl_->effort);
  impl_->command.setZero();
  impl_->last_valid_effort.setZero();
  impl_->plan.forget();
}

const ContactList& InverseController::contacts() const {
  return impl_->now->finder.list();
}

const ContactSearch& InverseController::contactSearch() const {
  return impl_->plan.search();
}

const std::vector<Vec3>& InverseController::nodes() const {
  return impl_->positions();
}

void InverseController::calcCablePoints(int cable, std::vector<Vec3>& points) const {
  impl_->shown().calcCablePoints(cable, points);
}

}  // namespace sinew
