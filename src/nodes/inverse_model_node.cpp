#include "inverse_model_node.h"

#include <ros/console.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <sstream>

#include "sinew/robot/robot_description.h"

namespace sinew {

namespace {

constexpr double kFirstCommandTolerance = 1e-4;  // m between the measured displacement and the first command
constexpr double kSessionGrace = 0.5;            // s until the driver has to have taken up the session
constexpr double kAutoEnablePeriod = 0.5;        // s
constexpr double kStatisticsPeriod = 0.1;        // s

std::uint32_t drawSession() {
  std::random_device device;
  return std::uniform_int_distribution<std::uint32_t>(1)(device);
}

std::uint64_t calcDivider(double rate, double wanted) {
  return static_cast<std::uint64_t>(std::max(1.0, std::round(rate / wanted)));
}

bool takesCommands(std::uint8_t driver_state) {
  return driver_state == ActuatorState::READY || driver_state == ActuatorState::ACTIVE ||
         driver_state == ActuatorState::HOLDING;
}

/// Counts by reason, the last refusal in words, and a warning when there are more than at the last report.
void reportRefusals(const std::string& what, const RefusalLog& log, std::uint64_t& reported,
                    diagnostic_updater::DiagnosticStatusWrapper& status) {
  const RefusalLog::Counts counts = log.counts();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    status.add(what + " refused: " + nameOf(static_cast<RefusalReason>(i)), counts[i]);
  }
  status.add(what + " last refused", log.last());
  const std::uint64_t total = log.total();
  if (total > reported) status.mergeSummary(diagnostic_msgs::DiagnosticStatus::WARN, "refused: " + log.last());
  reported = total;
}

std::vector<std::string> makeLostWords(const RobotModel& robot) {
  std::vector<std::string> words;
  for (const Obstacle& obstacle : robot.obstacles()) {
    words.push_back("held: obstacle '" + obstacle.name + "' is lost, its tracker is silent");
  }
  return words;
}

std::string inMillimetres(double length) {
  std::ostringstream stream;
  stream << 1e3 * length << " mm";
  return stream.str();
}

}  // namespace

InverseModelNode::Settings::Settings(const Parameters& parameters)
    : rate(parameters.numberOr("rate", 100, 1, 2000)),
      body_state_rate(parameters.numberOr("body_state_rate", 30, 0.1, 1000)),
      driver_timeout(parameters.numberOr("driver_timeout", 0.5, 0.01, 60)),
      transform_tolerance(parameters.numberOr("transform_tolerance", 0.1, 0.0, 1e6)),
      obstacles(ObstacleInbox::Settings::read(parameters)),
      require_driver(parameters.flagOr("require_driver", true)),
      auto_enable(parameters.flagOr("auto_enable", false)),
      priority(parameters.integerOr("priority", kCyclePriority, 1, 98)) {}

InverseModelNode::InverseModelNode(ros::NodeHandle node, ros::NodeHandle private_node)
    : node_(node),
      settings_(Parameters(private_node)),
      robot_(std::make_shared<RobotModel>(readRobotDescription(Parameters(private_node).text("robot")))),
      frames_(node, robot_->description().frame, settings_.transform_tolerance),
      targets_(node, Parameters(private_node), robot_, frames_),
      obstacles_(node, "tracked_obstacles", settings_.obstacles, robot_, frames_),
      actuators_(node, robot_),
      body_(node, robot_),
      controller_(robot_),
      input_(controller_.makeInput()),
      output_(controller_.makeOutput()),
      applied_(robot_->actuatorCount()),
      followed_(VecX::Zero(robot_->actuatorCount())),
      last_command_(followed_),
      wake_up_(1 / settings_.rate),
      statistics_(kStages, static_cast<int>(settings_.rate)),
      command_(makeCommandMessage(*robot_)),
      state_(makeStateMessage(*robot_)),
      lost_words_(makeLostWords(*robot_)),
      body_divider_(calcDivider(settings_.rate, settings_.body_state_rate)),
      statistics_divider_(calcDivider(settings_.rate, 1 / kStatisticsPeriod)),
      command_publisher_(node.advertise<ActuatorCommand>("actuator_command", 1)),
      state_publisher_(node.advertise<ControllerState>("controller_state", 10)),
      service_thread_(service_queue_),
      diagnostics_(node, private_node) {
  for (const std::string& warning : robot_->warnings()) ROS_WARN_STREAM(robot_->description().name << ": " << warning);
  input_.period = 1 / settings_.rate;
  for (const Obstacle& obstacle : robot_->obstacles()) input_.obstacles.push_back({obstacle.pose, true});

  diagnostics_.setHardwareID(robot_->description().name);
  diagnostics_.add("control", this, &InverseModelNode::reportControl);
  diagnostics_.add("inputs", this, &InverseModelNode::reportInputs);
  if (!obstacles_.report().empty()) diagnostics_.add("obstacles", this, &InverseModelNode::reportObstacles);
  reported_at_ = steadyNow();

  private_node.setCallbackQueue(&service_queue_);
  enable_service_ = private_node.advertiseService("enable", &InverseModelNode::onEnable, this);
  disable_service_ = private_node.advertiseService("disable", &InverseModelNode::onDisable, this);
  reset_service_ = private_node.advertiseService("reset", &InverseModelNode::onReset, this);
  diagnostics_timer_ = private_node.createSteadyTimer(ros::WallDuration(1), &InverseModelNode::onDiagnostics, this);
  if (settings_.auto_enable) {
    auto_enable_timer_ =
        private_node.createSteadyTimer(ros::WallDuration(kAutoEnablePeriod), &InverseModelNode::onAutoEnable, this);
  }
  cycle_thread_ = std::thread(&InverseModelNode::runCycles, this);
  service_thread_.start();
}

InverseModelNode::~InverseModelNode() {
  service_thread_.stop();
  stop_ = true;
  cycle_thread_.join();
}

// ---------------------------------------------------------------------------------------------------- cycle thread

void InverseModelNode::runCycles() {
  raisePriority(settings_.priority);
  while (!stop_) {
    wake_up_.wait();
    runCycle(steadyNow());
  }
}

void InverseModelNode::runCycle(double begin) {
  ++cycle_;
  state_.period = last_begin_ < 0 ? wake_up_.period() : begin - last_begin_;
  last_begin_ = begin;
  const Mode mode = wanted_.load(std::memory_order_acquire);
  granted_.store(mode, std::memory_order_release);

  readInbox();
  if (mode != Mode::kParked) updateObstacles();
  switch (mode) {
    case Mode::kControlling:
      control();
      break;
    case Mode::kFollowing:
      follow();
      break;
    case Mode::kParked:
      rest("disabled while the model is being moved");
      break;
  }
  const ros::Time stamp = ros::Time::now();
  if (state_.status != ControllerState::DISABLED) {
    publishCommand(stamp);
    controller_.prepare(output_);  // the next command waits for its targets only
  }

  const double end = steadyNow();
  std::array<double, kStages> durations;
  calcStageDurations(mode == Mode::kParked ? StageTimes() : output_.times, end - begin, durations.data());
  statistics_.add(durations.data());
  if (end - wake_up_.scheduled() > wake_up_.period()) ++deadline_misses_;

  if (cycle_ % statistics_divider_ == 0) statistics_.update();
  if (mode != Mode::kParked && cycle_ % body_divider_ == 0) body_.hand(controller_, input_, output_, stamp);
  publishState(stamp);
  updateSummary();
}

void InverseModelNode::readInbox() {
  if (!actuators_.newest().update()) return;
  const ActuatorReading& reading = actuators_.newest().front();
  if (reading.session == session_ && session_ != 0) applied_.addReport(reading.sequence, reading.applied);
}

// Disabled, the model goes where the actuators are measured to be, no faster than they may move.
void InverseModelNode::follow() {
  const ActuatorReading& reading = actuators_.newest().front();
  if (isDriverFresh(reading, last_begin_)) {
    for (int i = 0; i < followed_.size(); ++i) {
      const Limits& limits = robot_->actuators()[static_cast<std::size_t>(i)].displacement;
      const double step = limits.rate * input_.period;
      followed_[i] += std::max(-step, std::min(step, reading.measured[i] - followed_[i]));
    }
  }
  std::fill(input_.targeted.begin(), input_.targeted.end(), false);
  input_.applied = followed_;
  controller_.step(input_, output_);  // without a target it follows, and knows where the obstacles are
  rest(disabled_reason_.load(std::memory_order_acquire));
}

void InverseModelNode::rest(const char* reason) {
  std::fill(input_.targeted.begin(), input_.targeted.end(), false);
  state_.status = ControllerState::DISABLED;
  state_.reason = reason;
}

void InverseModelNode::control() {
  if (const char* reason = findReasonToStop()) {
    disabled_reason_.store(reason, std::memory_order_release);
    Mode expected = Mode::kControlling;
    wanted_.compare_exchange_strong(expected, Mode::kFollowing, std::memory_order_acq_rel);
    rest(reason);
    return;
  }
  updateTargets();
  if (with_driver_) {
    input_.applied = applied_.applied();
  } else {
    input_.applied.resize(0);
  }
  controller_.step(input_, output_);
  holdIfNotFinite();
  if (lost_ >= 0) holdForObstacle();
  last_command_ = output_.displacement;
  followed_ = last_command_;
  applied_.addCommand(++sequence_, last_command_);
  if (output_.status == CycleStatus::kHeld) ++held_[static_cast<std::size_t>(output_.reason)];
  state_.status = output_.status == CycleStatus::kSolved     ? ControllerState::TRACKING
                  : output_.status == CycleStatus::kDegraded ? ControllerState::DEGRADED
                                                             : ControllerState::HELD;
  state_.reason = lost_ >= 0 ? lost_words_[static_cast<std::size_t>(lost_)].c_str() : describe(output_);
}

void InverseModelNode::updateTargets() {
  targets_.newest().update();
  const TargetSet& targets = targets_.newest().front();
  const bool current = targets.epoch == targets_.epoch() && lost_ < 0;
  for (std::size_t i = 0; i < input_.targeted.size(); ++i) input_.targeted[i] = current && targets.targeted[i];
  input_.targets = targets.positions;
}

// Where they will be when the command of this cycle has been carried out.
void InverseModelNode::updateObstacles() {
  obstacles_.newest().update();
  obstacles_.predict(last_begin_ + input_.period, input_.obstacles);
  lost_ = obstacles_.findLost(last_begin_);
}

// The model has followed what is applied, without a target, so that the robot stands still.
void InverseModelNode::holdForObstacle() {
  if (output_.status == CycleStatus::kHeld) return;
  output_.status = CycleStatus::kHeld;
  output_.reason = HoldReason::kNone;
}

const char* InverseModelNode::findReasonToStop() {
  if (!with_driver_) return nullptr;
  const ActuatorReading& reading = actuators_.newest().front();
  if (!isDriverFresh(reading, last_begin_)) return "disabled: the driver's state stopped arriving";
  if (!takesCommands(reading.driver_state)) return "disabled: the driver left the states that take commands";
  if (reading.session != session_ && last_begin_ - enabled_since_ > kSessionGrace) {
    return "disabled: the driver obeys another session";
  }
  return nullptr;
}

bool InverseModelNode::isDriverFresh(const ActuatorReading& reading, double now) const {
  return reading.receipt >= 0 && now - reading.receipt <= settings_.driver_timeout;
}

void InverseModelNode::holdIfNotFinite() {
  if (output_.displacement.allFinite()) return;
  output_.displacement = last_command_;
  output_.status = CycleStatus::kHeld;
  output_.reason = HoldReason::kNotFinite;
}

void InverseModelNode::publishCommand(const ros::Time& stamp) {
  command_.header.stamp = stamp;
  command_.session = session_;
  command_.sequence = sequence_;
  updateCommandMessage(output_, command_);
  command_publisher_.publish(command_);
}

void InverseModelNode::publishState(const ros::Time& stamp) {
  const bool enabled = state_.status != ControllerState::DISABLED;
  state_.header.stamp = stamp;
  state_.session = enabled ? session_ : 0;
  state_.sequence = enabled ? sequence_ : 0;
  state_.cycle = cycle_;
  state_.deadline_misses = deadline_misses_;
  if (granted_.load(std::memory_order_relaxed) != Mode::kParked) updateStateMessage(*robot_, input_, output_, state_);
  updateStageMessages(statistics_, state_.stages);
  updateInputStamps();
  state_publisher_.publish(state_);
}

void InverseModelNode::updateInputStamps() {
  state_.inputs.clear();
  const auto add = [this](const std::string& topic, const MessageStamp& source) {
    InputStamp input;
    input.topic = topic;
    input.stamp = source.stamp;
    input.sequence = source.sequence;
    const bool known = std::any_of(state_.inputs.begin(), state_.inputs.end(), [&input](const InputStamp& other) {
      return other.topic == input.topic && other.stamp == input.stamp && other.sequence == input.sequence;
    });
    if (!known) state_.inputs.push_back(input);
  };
  const TargetSet& targets = targets_.newest().front();
  for (std::size_t i = 0; i < input_.targeted.size(); ++i) {
    if (input_.targeted[i]) add(targets_.topics()[static_cast<std::size_t>(targets.topic[i])], targets.source[i]);
  }
  for (const ObstacleSighting& sighting : obstacles_.newest().front()) {
    if (sighting.receipt >= 0) add(obstacles_.topic(), sighting.source);
  }
  const ActuatorReading& reading = actuators_.newest().front();
  if (reading.receipt >= 0) add(actuators_.topic(), reading.source);
}

void InverseModelNode::updateSummary() {
  Summary& summary = summary_.back();
  summary.status = state_.status;
  summary.cycle = cycle_;
  summary.deadline_misses = deadline_misses_;
  summary.held = held_;
  summary.median = statistics_.median(kStages - 1);
  summary.maximum = statistics_.maximum(kStages - 1);
  summary_.publish();
}

// -------------------------------------------------------------------------------------------------- service thread

bool InverseModelNode::onEnable(Trigger::Request&, Trigger::Response& response) {
  const std::string refusal = enable();
  response.success = refusal.empty();
  response.message = refusal.empty() ? "enabled" : refusal;
  return true;
}

bool InverseModelNode::onDisable(Trigger::Request&, Trigger::Response& response) {
  park();
  release(Mode::kFollowing, "disabled by request");
  response.success = true;
  response.message = "disabled";
  return true;
}

bool InverseModelNode::onReset(Trigger::Request&, Trigger::Response& response) {
  park();
  controller_.reset();
  followed_.setZero();
  targets_.forget();
  release(Mode::kFollowing, "reset by request");
  response.success = true;
  response.message = "disabled, the model is at rest and the targets are forgotten";
  return true;
}

void InverseModelNode::onAutoEnable(const ros::SteadyTimerEvent&) {
  if (wanted_.load() == Mode::kControlling) return;
  const std::string refusal = enable();
  if (refusal == refused_to_enable_) return;
  refused_to_enable_ = refusal;
  if (refusal.empty()) {
    ROS_INFO("enabled");
  } else {
    ROS_INFO_STREAM("not enabled yet: " << refusal);
  }
}

std::string InverseModelNode::enable() {
  if (wanted_.load() == Mode::kControlling) return "";
  const ActuatorReading reading = actuators_.latest();
  const bool with_driver = settings_.require_driver || isDriverFresh(reading, steadyNow());
  if (with_driver) {
    const std::string reason = findReasonNotToEnable(reading);
    if (!reason.empty()) return reason;
  }
  park();
  targets_.forget();
  with_driver_ = with_driver;
  const VecX start = with_driver ? reading.measured : followed_;
  const std::string failure = resynchronise(start);
  if (!failure.empty()) {
    release(Mode::kFollowing, "enabling was refused");
    return failure;
  }
  applied_.reset(start);
  session_ = drawSession();
  sequence_ = 0;
  enabled_since_ = steadyNow();
  release(Mode::kControlling, "");
  return "";
}

std::string InverseModelNode::findReasonNotToEnable(const ActuatorReading& reading) const {
  if (!isDriverFresh(reading, steadyNow())) {
    return reading.receipt < 0 ? "no message on " + actuators_.topic() + " yet: is the driver running?"
                               : "the last message on " + actuators_.topic() + " is older than driver_timeout";
  }
  if (!takesCommands(reading.driver_state)) {
    return std::string("the driver is ") + nameOfDriverState(reading.driver_state) +
           ", it has to be READY, ACTIVE or HOLDING: " + actuators_.driverReason();
  }
  if (!reading.all_measured) return "the driver could not read every actuator";
  if (!reading.all_zeroed) return "an actuator does not know its zero: home it first";
  if (reading.session != 0) return "the driver obeys another session: call its recover service first";
  return "";
}

// Moves the parked model to the measurement and tries the first command, with every effector free, on the spot: what
// would move the robot on enabling is found out before anything is sent.
std::string InverseModelNode::resynchronise(const VecX& measured) {
  std::fill(input_.targeted.begin(), input_.targeted.end(), false);
  input_.applied = followed_;
  controller_.step(input_, output_);  // so that it knows where the obstacles are
  const double difference = controller_.resynchronise(measured);
  if (!std::isfinite(difference)) return "the model finds no equilibrium at the measured displacements";
  if (difference > kFirstCommandTolerance) {
    return "the model comes no nearer to the measured displacements than " + inMillimetres(difference);
  }
  input_.applied = with_driver_ ? measured : VecX();
  if (controller_.step(input_, output_) == CycleStatus::kHeld) return describe(output_);
  followed_ = measured;
  last_command_ = output_.displacement;
  return compareFirstCommand(with_driver_ ? actuators_.latest().measured : measured);
}

std::string InverseModelNode::compareFirstCommand(const VecX& measured) const {
  for (int i = 0; i < measured.size(); ++i) {
    const double difference = std::abs(last_command_[i] - measured[i]);
    if (difference <= kFirstCommandTolerance) continue;
    return "the first command for " + robot_->actuators()[static_cast<std::size_t>(i)].name + " would be " +
           inMillimetres(difference) + " from its measurement, more than " + inMillimetres(kFirstCommandTolerance);
  }
  return "";
}

// Granted at the start of a cycle that leaves the controller alone, and taken back by the first one that does not.
void InverseModelNode::park() {
  wanted_.store(Mode::kParked, std::memory_order_release);
  waitUntilParked(true);
}

void InverseModelNode::release(Mode mode, const char* reason) {
  disabled_reason_.store(reason, std::memory_order_release);
  wanted_.store(mode, std::memory_order_release);
  waitUntilParked(false);
}

void InverseModelNode::waitUntilParked(bool parked) const {
  while ((granted_.load(std::memory_order_acquire) == Mode::kParked) != parked) {
    std::this_thread::sleep_for(std::chrono::duration<double>(input_.period / 4));
  }
}

void InverseModelNode::onDiagnostics(const ros::SteadyTimerEvent&) {
  diagnostics_.force_update();
}

void InverseModelNode::reportControl(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  summary_.update();
  const Summary& now = summary_.front();
  const double time = steadyNow();
  const std::uint64_t misses = now.deadline_misses - reported_.deadline_misses;
  std::uint64_t held = 0;
  for (std::size_t i = 0; i < now.held.size(); ++i) held += now.held[i] - reported_.held[i];

  status.summary(DiagnosticStatus::OK, now.status == ControllerState::DISABLED ? disabled_reason_.load() : "tracking");
  if (now.status == ControllerState::DEGRADED) status.summary(DiagnosticStatus::WARN, "an effort limit gives way");
  if (misses > 0)
    status.mergeSummaryf(DiagnosticStatus::WARN, "%lu deadlines missed", static_cast<unsigned long>(misses));
  if (held > 0) status.mergeSummaryf(DiagnosticStatus::WARN, "%lu cycles held", static_cast<unsigned long>(held));
  if (now.status == ControllerState::HELD) status.mergeSummary(DiagnosticStatus::ERROR, "held");

  status.addf("rate [Hz]", "%.2f",
              static_cast<double>(now.cycle - reported_.cycle) / std::max(time - reported_at_, 1e-3));
  status.add("cycles", now.cycle);
  status.addf("cycle median [ms]", "%.3f", 1e3 * now.median);
  status.addf("cycle maximum [ms]", "%.3f", 1e3 * now.maximum);
  status.add("deadline misses", now.deadline_misses);
  status.add("held: not finite", now.held[static_cast<std::size_t>(HoldReason::kNotFinite)]);
  status.add("held: not positive definite", now.held[static_cast<std::size_t>(HoldReason::kNotPositiveDefinite)]);
  status.add("held: obstacle lost", now.held[static_cast<std::size_t>(HoldReason::kNone)]);
  status.add("held: quadratic program", now.held[static_cast<std::size_t>(HoldReason::kQpFailed)]);
  reported_ = now;
  reported_at_ = time;
}

void InverseModelNode::reportInputs(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "no message refused");
  reportRefusals("targets", targets_.refusals(), reported_target_refusals_, status);
  reportRefusals("actuator state", actuators_.refusals(), reported_driver_refusals_, status);
  reportRefusals("obstacles", obstacles_.refusals(), reported_obstacle_refusals_, status);
  status.add("targets accepted", targets_.accepted());
  status.add("obstacles accepted", obstacles_.accepted());
  const ActuatorReading reading = actuators_.latest();
  status.add("driver", reading.receipt < 0 ? "nothing heard" : nameOfDriverState(reading.driver_state));
  status.addf("driver state age [s]", "%.3f", reading.receipt < 0 ? -1.0 : steadyNow() - reading.receipt);
}

void InverseModelNode::reportObstacles(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "every obstacle is where it is thought to be");
  std::uint64_t outliers = 0;
  for (const ObstacleInbox::Report& report : obstacles_.report()) {
    const char* const state = !report.heard     ? "not heard of, taken to be where the robot's description says"
                              : report.lost     ? "lost"
                              : !report.present ? "absent"
                                                : "present";
    if (!report.heard) status.mergeSummary(DiagnosticStatus::WARN, "obstacle '" + report.name + "' is not heard of");
    if (report.lost) status.mergeSummary(DiagnosticStatus::ERROR, "obstacle '" + report.name + "' is lost");
    status.add(report.name, state);
    status.addf(report.name + " age [s]", "%.3f", report.age);
    status.add(report.name + " outliers", report.outliers);
    outliers += report.outliers;
  }
  if (outliers > reported_outliers_) status.mergeSummary(DiagnosticStatus::WARN, obstacles_.lastOutlier());
  reported_outliers_ = outliers;
}

}  // namespace sinew
