#include "control_cycle.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {
namespace {

constexpr double kSessionGrace = 0.5;  // s until the driver has to have taken up the session
constexpr double kSearchShare = 0.4;   // of a period, for the search among contacts
constexpr double kCostGain = 0.1;      // of the newest renewal in the mean
constexpr int kRenewalCycles = 2;      // at least so many share a linearisation, which leaves the processor to others

std::vector<std::string> makeLostWords(const RobotModel& robot) {
  std::vector<std::string> words;
  for (const Obstacle& obstacle : robot.obstacles()) {
    words.push_back("held: obstacle '" + obstacle.name + "' is lost, its tracker is silent");
  }
  return words;
}

OverloadLadder::Settings adaptTo(const RobotModel& robot, OverloadLadder::Settings settings) {
  settings.useful = {{true, robot.description().control.newton_steps > 1, robot.maxContacts() > 0, true}};
  return settings;
}

std::uint64_t calcDivider(double rate, double wanted) {
  return static_cast<std::uint64_t>(std::max(1.0, std::round(rate / wanted)));
}

std::uint8_t toStatus(CycleStatus status) {
  switch (status) {
    case CycleStatus::kSolved:
      return ControllerState::TRACKING;
    case CycleStatus::kDegraded:
      return ControllerState::DEGRADED;
    case CycleStatus::kHeld:
      break;
  }
  return ControllerState::HELD;
}

}  // namespace

ControlCycle::ControlCycle(const ControlSettings& settings, std::shared_ptr<const RobotModel> robot,
                           const Inboxes& inboxes, ControlMode& mode, ControlSession& session,
                           CyclePublisher& publisher, BodyPublisher& body)
    : settings_(settings),
      robot_(std::move(robot)),
      inboxes_(inboxes),
      mode_(mode),
      session_(session),
      publisher_(publisher),
      body_(body),
      renewal_(session.controller),
      ladder_(adaptTo(*robot_, settings.overload)),
      lost_words_(makeLostWords(*robot_)),
      period_(settings.period()),
      body_divider_(calcDivider(settings.rate, settings.body_state_rate)) {
  session_.input.search_time = kSearchShare * settings_.period();
}

ControlCycle::~ControlCycle() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void ControlCycle::start() {
  thread_ = std::thread(&ControlCycle::runAll, this);
}

void ControlCycle::runAll() {
  nameThread("cycle");
  raisePriority(settings_.priority);
  PeriodicWakeUp wake_up(settings_.period());
  while (!stop_) {
    wake_up.wait();
    run(wake_up);
  }
}

void ControlCycle::run(const PeriodicWakeUp& wake_up) {
  const double begin = steadyNow();
  if (begin_ >= 0) period_ = begin - begin_;
  begin_ = begin;
  ++cycle_;
  const Mode mode = mode_.grant();
  readInboxes();
  act(mode);
  const bool enabled = status_ != ControllerState::DISABLED;
  if (enabled) handCommand();
  answered_ = steadyNow() - wake_up.scheduled();
  if (mode != Mode::kParked) linearise(enabled);
  if (mode != Mode::kParked && cycle_ % body_divider_ == 0) {
    body_.hand(session_.controller, session_.input, session_.output);
  }
  const double end = steadyNow();
  handCycle(mode, wake_up, end);
  if (mode != Mode::kParked) updateLevel(end - begin);
}

void ControlCycle::readInboxes() {
  inboxes_.targets.newest().update();
  inboxes_.obstacles.newest().update();
  if (!inboxes_.actuators.newest().update()) return;
  const DriverReading& reading = inboxes_.actuators.newest().front();
  if (reading.session == session_.session && session_.session != 0) {
    session_.applied.addReport(reading.sequence, reading.applied);
  }
}

void ControlCycle::act(Mode mode) {
  if (mode == Mode::kParked) {
    rest("disabled while the model is being moved");
    return;
  }
  updateObstacles();
  session_.input.overload = ladder_.level();
  if (mode == Mode::kControlling) {
    control();
  } else {
    follow();
  }
}

// Where they will be when the command of this cycle has been carried out.
void ControlCycle::updateObstacles() {
  inboxes_.obstacles.predict(begin_ + settings_.period(), session_.input.obstacles);
  lost_ = inboxes_.obstacles.findLost(begin_);
}

// Disabled, the model goes where the actuators are measured to be, no faster than they may move.
void ControlCycle::follow() {
  const DriverReading& reading = inboxes_.actuators.newest().front();
  if (isFresh(reading, begin_, settings_.driver_timeout)) {
    for (int i = 0; i < session_.followed.size(); ++i) {
      const Limits& limits = robot_->actuators()[static_cast<std::size_t>(i)].displacement;
      const double step = limits.rate * settings_.period();
      session_.followed[i] += std::max(-step, std::min(step, reading.measured[i] - session_.followed[i]));
    }
  }
  std::fill(session_.input.targeted.begin(), session_.input.targeted.end(), false);
  session_.input.applied = session_.followed;
  step();  // without a target it follows, and knows where the obstacles are
  rest(mode_.disabledReason());
}

void ControlCycle::rest(const char* reason) {
  std::fill(session_.input.targeted.begin(), session_.input.targeted.end(), false);
  report(ControllerState::DISABLED, reason);
}

void ControlCycle::report(std::uint8_t status, const char* reason) {
  status_ = status;
  reason_ = reason;
}

void ControlCycle::control() {
  if (const char* reason = findReasonToStop()) {
    mode_.disable(reason);
    rest(reason);
    return;
  }
  updateTargets();
  session_.input.applied = session_.with_driver ? session_.applied.applied() : session_.last_command;
  step();
  holdIfNotFinite();
  if (lost_ >= 0) holdForObstacle();
  recordCommand();
  report(toStatus(session_.output.status),
         lost_ >= 0 ? lost_words_[static_cast<std::size_t>(lost_)].c_str() : describe(session_.output));
}

const char* ControlCycle::findReasonToStop() const {
  if (!session_.with_driver) return nullptr;
  const DriverReading& reading = inboxes_.actuators.newest().front();
  if (!isFresh(reading, begin_, settings_.driver_timeout)) return "disabled: the driver's state stopped arriving";
  if (!takesCommands(reading.driver_state)) return "disabled: the driver left the states that take commands";
  if (reading.session != session_.session && begin_ - session_.enabled_since > kSessionGrace) {
    return "disabled: the driver obeys another session";
  }
  return nullptr;
}

void ControlCycle::updateTargets() {
  const TargetSet& targets = inboxes_.targets.newest().front();
  const bool current = targets.epoch == inboxes_.targets.epoch() && lost_ < 0;
  CycleInput& input = session_.input;
  for (std::size_t i = 0; i < input.targeted.size(); ++i) input.targeted[i] = current && targets.targeted[i];
  input.targets = targets.positions;
}

void ControlCycle::step() {
  const bool shared = session_.input.overload == OverloadLevel::kSharedLinearisation;
  if (shared && renewal_.idle()) session_.controller.endRenewal();
  session_.controller.step(session_.input, session_.output);
}

void ControlCycle::holdIfNotFinite() {
  CycleOutput& output = session_.output;
  if (output.displacement.allFinite()) return;
  output.displacement = session_.last_command;
  output.status = CycleStatus::kHeld;
  output.reason = HoldReason::kNotFinite;
}

// The model has followed what is applied, without a target, so that the robot stands still.
void ControlCycle::holdForObstacle() {
  CycleOutput& output = session_.output;
  if (output.status == CycleStatus::kHeld) return;
  output.status = CycleStatus::kHeld;
  output.reason = HoldReason::kNone;
}

void ControlCycle::recordCommand() {
  session_.last_command = session_.output.displacement;
  session_.followed = session_.last_command;
  session_.applied.addCommand(++session_.sequence, session_.last_command);
}

void ControlCycle::handCommand() {
  CommandRecord* const record = publisher_.command();
  if (record == nullptr) {
    publisher_.countUnsent();
    return;
  }
  record->session = session_.session;
  record->sequence = session_.sequence;
  record->status = session_.output.status;
  record->displacement = session_.output.displacement;
  if (record->status == CycleStatus::kHeld)
    record->effort.setConstant(std::numeric_limits<double>::quiet_NaN());
  else
    record->effort = session_.output.effort;
  publisher_.handCommand();
}

// For the next cycle: its command then waits for its targets only.
void ControlCycle::linearise(bool enabled) {
  ++since_renewal_;
  if (session_.input.overload != OverloadLevel::kSharedLinearisation) {
    if (enabled) session_.controller.prepare(session_.output);
    return;
  }
  if (since_renewal_ < kRenewalCycles || !renewal_.idle()) return;
  since_renewal_ = 0;
  const double cost = renewal_.cost();
  if (cost >= 0) renewal_cost_ = renewal_cost_ < 0 ? cost : renewal_cost_ + kCostGain * (cost - renewal_cost_);
  session_.controller.beginRenewal();
  renewal_.start();
}

void ControlCycle::updateLevel(double taken) {
  CycleCost cost;
  cost.taken = taken;
  const ControlDescription& control = robot_->description().control;
  if (ladder_.level() == OverloadLevel::kSharedLinearisation) {
    const double bodies = control.model == MotionModel::kDynamic ? 2 : 1;
    cost.spared = renewal_cost_ < 0 ? settings_.period() : bodies * renewal_cost_;  // unknown: too much
  } else if (ladder_.level() == OverloadLevel::kOneNewtonStep) {
    cost.spared = (control.newton_steps - 1) * taken;
  }
  ladder_.update(cost, settings_.period());
}

void ControlCycle::handCycle(Mode mode, const PeriodicWakeUp& wake_up, double end) {
  CycleRecord* const record = publisher_.cycle();
  if (record == nullptr) return;
  const bool enabled = status_ != ControllerState::DISABLED;
  record->status = status_;
  record->reason = reason_;
  record->session = enabled ? session_.session : 0;
  record->sequence = enabled ? session_.sequence : 0;
  record->cycle = cycle_;
  record->period = period_;
  record->answered = answered_;
  record->skipped = wake_up.skipped();
  record->modelled = mode != Mode::kParked;
  if (record->modelled) {
    record->targets = session_.input.targets;
    record->targeted = session_.input.targeted;
    record->output = session_.output;
  }
  calcStageDurations(record->modelled ? session_.output.times : StageTimes(), end - begin_, record->durations.data());
  listInputs(*record);
  publisher_.handCycle();
}

void ControlCycle::listInputs(CycleRecord& record) const {
  record.input_count = 0;
  const TargetSet& targets = inboxes_.targets.newest().front();
  for (std::size_t i = 0; i < record.targeted.size(); ++i) {
    if (!session_.input.targeted[i]) continue;
    record.addInput(inboxes_.targets.topics()[static_cast<std::size_t>(targets.topic[i])], targets.source[i]);
  }
  for (const ObstacleSighting& sighting : inboxes_.obstacles.newest().front()) {
    if (sighting.receipt >= 0) record.addInput(inboxes_.obstacles.topic(), sighting.source);
  }
  const DriverReading& reading = inboxes_.actuators.newest().front();
  if (reading.receipt >= 0) record.addInput(inboxes_.actuators.topic(), reading.source);
}

}  // namespace sinew
