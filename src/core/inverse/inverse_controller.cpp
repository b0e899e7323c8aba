#include "sinew/inverse/inverse_controller.h"

#include <algorithm>
#include <cmath>

#include "sinew/constraint/cable.h"
#include "sinew/constraint/point_effector.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/contact_piece.h"
#include "sinew/inverse/contact_search.h"
#include "sinew/inverse/forward_step.h"
#include "sinew/inverse/inverse_problem.h"
#include "sinew/inverse/step_damping.h"

namespace sinew {
namespace {

constexpr double kSyncStep = 5e-3;  // m of cable per load step when the model is moved to a measurement
constexpr double kSyncTolerance = 1e-9;
constexpr int kSyncIterations = 100;

// Far from its goal the error is large and the curvature of the reachable positions, which the linear problem does not
// see, decides over convergence: the change of effort is damped, and a gain too small to matter ends the chase.
constexpr double kFarGoalDamping = 0.3;   // of the best-driven direction
constexpr double kNegligibleGain = 2e-5;  // of the reach of one cycle

constexpr double kOnLimit = 1e-9;  // of the range, within which a limit counts as reached

int maxEffectorRows(const RobotModel& robot) {
  int rows = 0;
  for (const PointEffector& effector : robot.effectors()) rows += effector.rowCount();
  return rows;
}

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

ContactFinder* activeOrNull(ContactFinder& finder) {
  return finder.active() ? &finder : nullptr;
}

}  // namespace

// The body of a dynamic robot: it follows the commanded displacements with inertia and damping, apart from the plan.
// Planning about the moving state instead would make the settled answer depend on the period, since A^-1 then decides
// over the actuators' redundancy, and lets vibrations into the commands.
struct MovingBody {
  CondensedRobot condensed;
  ContactFinder finder;
  ForwardStep forward;
  Actuation winches;
  VecX effort;

  explicit MovingBody(const std::shared_ptr<const RobotModel>& robot)
      : condensed(robot), finder(*robot), forward(*robot), effort(VecX::Zero(robot->actuatorCount())) {
    winches.mode.assign(static_cast<std::size_t>(robot->actuatorCount()), Actuation::Mode::kDisplacement);
    winches.value = VecX::Zero(robot->actuatorCount());
  }

  ForwardStatus follow(const VecX& displacement, double period, StageTimes& times) {
    winches.value = displacement;
    const ForwardStatus status =
        forward.step(winches, condensed.makeRule(period), activeOrNull(finder), condensed, effort, times);
    if (status != ForwardStatus::kSolved) condensed.body().abandonStep();
    return status;
  }

  void place(const std::vector<Vec3>& positions, const VecX& new_effort) {
    condensed.body().place(positions);
    effort = new_effort;
  }
};

struct InverseController::Impl {
  std::shared_ptr<const RobotModel> robot;
  CondensedRobot condensed;
  std::unique_ptr<MovingBody> moving;  // of a dynamic robot
  ContactFinder finder;
  ForwardStep forward;
  EffectorGoal goal;
  ContactSearch search;
  ContactPiece piece;
  std::vector<char> none_pressing;
  InverseProblem problem;
  InverseProblemData data;
  InverseProblemResult result;
  CycleLimits limits;
  Actuation held;
  VecX effort;               // N, total
  VecX command;              // m, of the last cycle
  VecX cycle_start;          // m, what the rates of this cycle count from
  VecX linear_displacement;  // m, actuators as the linear problem moves them
  VecX contact_force;        // N, of this cycle's contacts
  VecX contact_gap;          // m
  VecX gap_shift, drift;     // m, of contacts and rows
  VecX row_motion;           // m, every row
  VecX last_valid_effort;
  StepDamping damping;
  bool pressed = false;   // some contact did, in the last cycle
  bool prepared = false;  // `condensed` holds the linear problem of the next step

  explicit Impl(std::shared_ptr<const RobotModel> model)
      : robot(model),
        condensed(model),
        finder(*model),
        forward(*model),
        goal(maxEffectorRows(*model)),
        search(*model, maxEffectorRows(*model)),
        piece(model->actuatorCount(), maxEffectorRows(*model), model->maxContacts()),
        none_pressing(static_cast<std::size_t>(model->maxContacts()), 0),
        problem(model->actuatorCount(), maxEffectorRows(*model), model->maxContacts()),
        data(model->actuatorCount(), maxEffectorRows(*model), model->maxContacts()),
        result(model->actuatorCount()),
        limits(model->actuatorCount()),
        effort(VecX::Zero(model->actuatorCount())),
        command(VecX::Zero(model->actuatorCount())),
        cycle_start(VecX::Zero(model->actuatorCount())),
        linear_displacement(VecX::Zero(model->actuatorCount())),
        contact_force(VecX::Zero(model->maxContacts())),
        contact_gap(VecX::Zero(model->maxContacts())),
        gap_shift(VecX::Zero(model->maxContacts())),
        drift(VecX::Zero(model->actuatorCount() + maxEffectorRows(*model))),
        row_motion(VecX::Zero(model->actuatorCount() + maxEffectorRows(*model) + model->maxContacts())),
        last_valid_effort(VecX::Zero(model->actuatorCount())) {
    held.mode.assign(static_cast<std::size_t>(actuators()), Actuation::Mode::kDisplacement);
    held.value = VecX::Zero(actuators());
    if (model->description().control.model == MotionModel::kDynamic) moving = std::make_unique<MovingBody>(model);
  }

  const std::vector<Vec3>& positions() const { return (moving ? moving->condensed : condensed).body().positions(); }

  int actuators() const { return robot->actuatorCount(); }
  const Limits& displacementLimits(int i) const { return robot->cables()[i].description().displacement; }
  const Limits& tensionLimits(int i) const { return robot->cables()[i].description().tension; }

  bool validInput(const CycleInput& input) const {
    return input.targets.size() == 3 * robot->effectorCount() &&
           static_cast<int>(input.targeted.size()) == robot->effectorCount() &&
           (input.applied.size() == 0 || input.applied.size() == actuators()) && input.applied.allFinite() &&
           std::isfinite(input.period) && input.period > 0;
  }

  // A rate is hard: outside the range the command comes back no faster than the rate allows.
  void updateLimits(double period) {
    for (int i = 0; i < actuators(); ++i) {
      const Limits& range = displacementLimits(i);
      const double step = range.rate * period;
      limits.displacement_min[i] = std::min(std::max(range.min, cycle_start[i] - step), cycle_start[i] + step);
      limits.displacement_max[i] = std::max(std::min(range.max, cycle_start[i] + step), cycle_start[i] - step);
      const Limits& tension = tensionLimits(i);
      const double change = tension.rate * period;
      limits.effort_min[i] = std::max(tension.min, last_valid_effort[i] - change);
      limits.effort_max[i] = std::min(tension.max, last_valid_effort[i] + change);
      limits.effort_min[i] = std::min(limits.effort_min[i], limits.effort_max[i]);
    }
  }

  // The targeted effectors' rows and their present error. A goal farther than the reach of one cycle is chased part of
  // the way: one factor for all rows keeps the stationary points. What the body would move by itself is added whole.
  double gatherGoal(const CycleInput& input, CycleOutput& output) {
    int row = actuators(), used = 0;
    goal.rows.clear();
    for (int e = 0; e < robot->effectorCount(); ++e) {
      const PointEffector& effector = robot->effectors()[e];
      const int count = effector.rowCount();
      if (input.targeted[e]) {
        effector.calcError(condensed.body().positions(), input.targets.segment<3>(3 * e), goal.error.data() + used);
        for (int k = 0; k < count; ++k) goal.rows.push_back(row + k);
        used += count;
      }
      row += count;
    }
    const ControlDescription& control = robot->description().control;
    const double distance = goal.error.head(used).norm();
    output.goal_scale = distance > control.reach_per_cycle ? control.reach_per_cycle / distance : 1.0;
    for (int k = 0; k < used; ++k)
      goal.error[k] = output.goal_scale * goal.error[k] + condensed.freeMotion()[goal.rows[k]];
    data.negligible_gain = output.goal_scale < 1 ? kNegligibleGain * control.reach_per_cycle : 0;
    return distance;
  }

  // How far the rows would move with efforts as they are, the moving of obstacles apart: what the last step left.
  double calcDrift() {
    const int n = actuators(), rows = piece.firstContact();
    for (int i = 0; i < piece.contacts(); ++i) gap_shift[i] = finder.calcGapShift(i);
    piece.calcResponse(gap_shift, drift);
    drift.head(rows) = piece.value().head(rows) - drift.head(rows);
    drift.head(n) -= condensed.displacement();
    return drift.head(rows).norm();
  }

  double calcDamping(double goal_scale) const {
    return robot->description().control.smoothing + damping.value() + kFarGoalDamping * (1 - goal_scale);
  }

  // The inverse problem within the present piece, contact forces eliminated.
  void gatherProblem(double goal_scale) {
    const int n = actuators();
    data.damping = calcDamping(goal_scale);
    data.effector_rows = static_cast<int>(goal.rows.size());
    for (int k = 0; k < data.effector_rows; ++k) {
      const int row = goal.rows[k];
      data.W_ea.row(k) = piece.W().row(row);
      data.effector_error[k] = goal.error[k] + (piece.value()[row] - condensed.freeMotion()[row]);
    }
    data.unit_compliance = condensed.compliance().diagonal().head(n);
    data.W_aa = piece.W().topRows(n);
    data.displacement = piece.value().head(n);
    data.effort = effort;
    data.contacts = piece.contacts();
    data.W_ca.topRows(data.contacts) = piece.W().bottomRows(data.contacts);
    data.contact.head(data.contacts) = piece.value().tail(data.contacts);
    data.contact_slack.head(data.contacts).setZero();
  }

  // The search has found a point of the piece; rounding must not make it look impossible.
  void allowSearched() {
    const VecX& found = search.solution().x;
    for (int i = 0; i < data.contacts; ++i) {
      data.contact_slack[i] = std::max(0.0, -(data.contact[i] + data.W_ca.row(i).dot(found.head(actuators()))));
    }
  }

  bool searchPiece(CycleOutput& output) {
    const QpccStatus status =
        search.solve(condensed, finder.list(), goal, limits, effort, calcDamping(output.goal_scale));
    const QpccSolution& found = search.solution();
    output.contacts.proved_global = found.proved_global;
    output.contacts.declined_better = found.declined_better;
    output.contacts.pieces += found.pieces;
    output.contacts.nodes += found.nodes;
    return (status == QpccStatus::kSolved || status == QpccStatus::kGivenWay) && piece.reduce(condensed, found.active);
  }

  HoldReason planEfforts(const CycleInput& input, CycleOutput& output) {
    const StageTimer timer(output.times.qp);
    if (!std::isfinite(gatherGoal(input, output))) return HoldReason::kNotFinite;
    const int contacts = condensed.contacts();
    if (contacts == 0) {
      piece.reduce(condensed, none_pressing);
    } else if (!searchPiece(output)) {
      return HoldReason::kQpFailed;
    }
    const bool let_go = pressed && contacts == 0;  // what held the body is gone: no fault of the last step
    damping.update(let_go ? 0 : calcDrift());
    gatherProblem(output.goal_scale);
    if (contacts > 0) allowSearched();
    output.qp_status = problem.solve(data, limits, result);
    output.qp_iterations += result.iterations;
    if (output.qp_status != QpStatus::kSolved) {
      if (contacts == 0 || search.solution().status != QpccStatus::kSolved) return HoldReason::kQpFailed;
      result.effort_change = search.solution().x.head(actuators());
      result.effort_violation.setZero();
    }
    piece.calcContacts(result.effort_change, contact_force, contact_gap);
    pressed = (contact_force.head(contacts).array() > 0).any();
    row_motion.head(condensed.rows()) = condensed.freeMotion();
    row_motion.head(condensed.rows()).noalias() += condensed.compliance().leftCols(actuators()) * result.effort_change;
    row_motion.head(condensed.rows()).noalias() +=
        condensed.compliance().rightCols(contacts) * contact_force.head(contacts);
    return HoldReason::kNone;
  }

  HoldReason factorise(StageTimes& times) {
    condensed.linearise(effort, StepRule(), times);
    if (!std::isfinite(condensed.residual())) return HoldReason::kNotFinite;
    return condensed.factorise(times) ? HoldReason::kNone : HoldReason::kNotPositiveDefinite;
  }

  HoldReason newtonStep(const CycleInput& input, CycleOutput& output) {
    HoldReason reason = prepared ? HoldReason::kNone : factorise(output.times);
    prepared = false;
    if (reason != HoldReason::kNone) return reason;
    if (finder.active()) {
      finder.find(condensed.body().positions(), output.times);
      condensed.addContacts(finder);
    }
    condensed.condense(output.times);
    reason = planEfforts(input, output);
    if (reason != HoldReason::kNone) return reason;

    const double scale = condensed.advance(result.effort_change, contact_force.head(condensed.contacts()),
                                           robot->maxNodeStep(), output.times);
    effort += scale * result.effort_change;
    damping.recordStep(scale * row_motion.head(condensed.firstContact()).norm());
    linear_displacement = condensed.displacement() + scale * row_motion.head(actuators());
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
    output.residual = condensed.residual();
    output.residual_relative = output.residual / std::max(condensed.loadNorm(), 1e-300);
    output.displacement = command;
    output.effort = effort;
    output.contacts.count = finder.list().size();
    output.contacts.force.head(output.contacts.count) = contact_force.head(output.contacts.count);
    output.contacts.gap.head(output.contacts.count) = contact_gap.head(output.contacts.count);
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
      if (command[i] - low <= near) {
        report(i, low == range.min ? LimitKind::kDisplacementMin : LimitKind::kRateMin,
               low == range.min ? range.min : range.rate, 0);
      }
      if (high - command[i] <= near) {
        report(i, high == range.max ? LimitKind::kDisplacementMax : LimitKind::kRateMax,
               high == range.max ? range.max : range.rate, 0);
      }
      const Limits& tension = tensionLimits(i);
      const double span = std::isfinite(tension.max) ? tension.max - std::max(tension.min, 0.0) : 1.0;
      if (effort[i] - tension.min <= kOnLimit * span) {
        report(i, LimitKind::kEffortMin, tension.min, std::max(0.0, tension.min - effort[i]));
      }
      if (tension.max - effort[i] <= kOnLimit * span) {
        report(i, LimitKind::kEffortMax, tension.max, std::max(0.0, effort[i] - tension.max));
      }
    }
  }

  // The model stands still with its cables held, and the command repeats the last valid one.
  CycleStatus hold(const CycleInput& input, HoldReason reason, CycleOutput& output) {
    effort = last_valid_effort;
    output.status = CycleStatus::kHeld;
    output.reason = reason;
    reportState(input, output);
    reportLimits(output);
    return output.status;
  }

  bool anyTarget(const CycleInput& input) const {
    return std::find(input.targeted.begin(), input.targeted.end(), true) != input.targeted.end();
  }

  // Ends a cycle whose plan stands: the dynamic body, where there is one, goes after the command.
  CycleStatus finish(const CycleInput& input, CycleStatus status, CycleOutput& output) {
    if (moving) {
      const ForwardStatus moved = moving->follow(command, input.period, output.times);
      if (moved != ForwardStatus::kSolved) return hold(input, reasonOf(moved), output);
    }
    output.status = status;
    output.reason = HoldReason::kNone;
    reportState(input, output);
    reportLimits(output);
    return status;
  }

  void see(const std::vector<ObstacleState>& obstacles) {
    finder.setObstacles(obstacles);
    if (moving) moving->finder.setObstacles(obstacles);
  }

  CycleStatus track(const CycleInput& input, CycleOutput& output) {
    if (input.applied.size() == actuators()) command = input.applied;
    cycle_start = command;
    last_valid_effort = effort;
    updateLimits(input.period);
    condensed.body().beginStep();
    bool gave_way = false;
    for (int k = 0; k < robot->description().control.newton_steps; ++k) {
      const HoldReason reason = newtonStep(input, output);
      if (reason != HoldReason::kNone) {
        condensed.body().abandonStep();
        return hold(input, reason, output);
      }
      ++output.newton_steps;
      gave_way = result.effort_violation.maxCoeff() > kOnLimit;
    }
    // Rounding must not carry a command past a hard limit.
    command = linear_displacement.cwiseMax(limits.displacement_min).cwiseMin(limits.displacement_max);
    return finish(input, gave_way ? CycleStatus::kDegraded : CycleStatus::kSolved, output);
  }

  CycleStatus follow(const CycleInput& input, const VecX& displacement, CycleOutput& output) {
    if (displacement.size() != actuators() || !displacement.allFinite()) {
      return hold(input, HoldReason::kNotFinite, output);
    }
    prepared = false;
    held.value = displacement;
    last_valid_effort = effort;
    cycle_start = displacement;
    updateLimits(input.period);
    const ForwardStatus status = forward.step(held, StepRule(), activeOrNull(finder), condensed, effort, output.times);
    search.forget();
    output.qp_iterations = forward.qpIterations();
    output.newton_steps = 1;
    if (status != ForwardStatus::kSolved) {
      condensed.body().abandonStep();
      return hold(input, reasonOf(status), output);
    }
    command = displacement;
    return finish(input, CycleStatus::kSolved, output);
  }

  double distanceTo(const VecX& measured) const {
    double worst = 0;
    for (int i = 0; i < actuators(); ++i) {
      const double excess = robot->cables()[i].calcDisplacement(condensed.body().positions()) - measured[i];
      const bool taut = effort[i] > tensionLimits(i).min + kSyncTolerance * effort.cwiseAbs().maxCoeff();
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

CycleStatus InverseController::step(const CycleInput& input, CycleOutput& output) {
  output.times = StageTimes();
  output.qp_iterations = output.newton_steps = 0;
  output.contacts.pieces = output.contacts.nodes = 0;
  output.goal_scale = 1;
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
  output.times = StageTimes();
  output.qp_iterations = output.newton_steps = 0;
  output.contacts.pieces = output.contacts.nodes = 0;
  output.goal_scale = 1;
  const StageTimer timer(output.times.cycle);
  CycleInput free = makeInput();
  free.period = period;
  return impl_->follow(free, displacement, output);
}

double InverseController::resynchronise(const VecX& measured) {
  Impl& impl = *impl_;
  const double failed = std::numeric_limits<double>::infinity();
  if (measured.size() != impl.actuators() || !measured.allFinite()) return failed;
  impl.prepared = false;
  VecX start(impl.actuators());
  for (int i = 0; i < impl.actuators(); ++i) {
    start[i] = impl.robot->cables()[i].calcDisplacement(impl.condensed.body().positions());
  }
  const int steps = 1 + static_cast<int>((measured - start).cwiseAbs().maxCoeff() / kSyncStep);
  StageTimes times;
  for (int k = 1; k <= steps; ++k) {
    impl.held.value = start + (measured - start) * k / steps;
    const double tolerance = k < steps ? 1e-3 : kSyncTolerance;
    if (impl.forward.settle(impl.held, tolerance, kSyncIterations, activeOrNull(impl.finder), impl.condensed,
                            impl.effort, times) != ForwardStatus::kSolved) {
      return failed;
    }
  }
  impl.command = measured;
  if (impl.moving) impl.moving->place(impl.condensed.body().positions(), impl.effort);
  impl.damping.reset();
  impl.problem.forget();
  impl.search.forget();
  return impl.distanceTo(measured);
}

void InverseController::reset() {
  impl_->prepared = false;
  impl_->condensed.reset();
  impl_->effort.setZero();
  if (impl_->moving) impl_->moving->place(impl_->condensed.body().positions(), impl_->effort);
  impl_->command.setZero();
  impl_->last_valid_effort.setZero();
  impl_->damping.reset();
  impl_->problem.forget();
  impl_->search.forget();
}

const ContactList& InverseController::contacts() const {
  return impl_->finder.list();
}

const std::vector<Vec3>& InverseController::nodes() const {
  return impl_->positions();
}

void InverseController::calcCablePoints(int cable, std::vector<Vec3>& points) const {
  robot().cables()[cable].calcPoints(nodes(), points);
}

}  // namespace sinew
