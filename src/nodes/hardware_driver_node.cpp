#include "hardware_driver_node.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/param.h>
#include <signal.h>

#include <exception>
#include <functional>

#include "line_opener.h"
#include "parameters.h"
#include "real_time.h"

namespace sinew {
namespace {

constexpr std::uint32_t kCommandBacklog = 50;  // messages
constexpr double kServiceTimeout = 60;         // s a service waits for its outcome, homing included
constexpr double kRetryPeriod = 1;             // s between attempts of ~auto_init
constexpr double kEarliestCycle = 0.5;         // periods after the last cycle
constexpr double kLatestCycle = 1.5;           // periods, while commands set the pace
constexpr double kSwitchOffTime = 2;           // s beyond relax_time

HardwareDescription loadDescription(const Parameters& parameters) {
  HardwareDescription description = HardwareDescription::load(parameters.text("hardware"));
  if (parameters.has("port")) description.movePorts(parameters.text("port"));
  return description;
}

std::string findZeroPath(const ros::NodeHandle& private_node) {
  const std::string path = Parameters(private_node).textOr("zero_file", makeZeroPath(private_node.getNamespace()));
  return path == "none" ? "" : path;
}

std::string listPorts(const HardwareDescription& description) {
  std::string list;
  for (const BusDescription& bus : description.buses) list += (list.empty() ? "" : ", ") + bus.port;
  return list;
}

}  // namespace

HardwareDriverNode::HardwareDriverNode(ros::NodeHandle node, ros::NodeHandle private_node)
    : description_(loadDescription(Parameters(private_node))),
      auto_init_(Parameters(private_node).flagOr("auto_init", false)),
      driver_(description_,
              makeBusGroup(description_, makeLineOpener(Parameters(private_node).flagOr("simulated", false)))),
      reader_(description_.names(), description_.quantities()),
      zeros_(findZeroPath(private_node)),
      for_diagnostics_(driver_.report()),
      node_(node),
      patient_(private_node, driver_.report()),
      urgent_(private_node, driver_.report()),
      diagnostics_(node, private_node),
      emergency_stops_(node, description_.emergency_stop.input, [this] { wake_up_.signal(); }) {
  message_.name = description_.names();
  for (const Quantity quantity : description_.quantities())
    message_.mode.push_back(static_cast<std::uint8_t>(quantity));
  for (const ActuatorDescription& actuator : description_.actuators) {
    message_.limit_min.push_back(actuator.min);
    message_.limit_max.push_back(actuator.max);
  }
  state_ = node_.advertise<ActuatorState>("actuator_state", 10);
  command_ = node_.subscribe("actuator_command", kCommandBacklog, &HardwareDriverNode::onCommand, this,
                             ros::TransportHints().tcpNoDelay());
  advertiseVerb(patient_, "init", DriverRequest::kInit);
  advertiseVerb(patient_, "home", DriverRequest::kHome);
  advertiseVerb(patient_, "recover", DriverRequest::kRecover);
  advertiseVerb(urgent_, "halt", DriverRequest::kHalt);
  advertiseVerb(urgent_, "emergency_stop", DriverRequest::kEmergency);
  advertiseVerb(urgent_, "shutdown", DriverRequest::kShutdown);
  diagnostics_.setHardwareID(listPorts(description_));
  diagnostics_.add("hardware driver", this, &HardwareDriverNode::diagnose);
  diagnostics_timer_ = node_.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) {
    diagnostics_.force_update();
    zeros_.update(message_.name, for_diagnostics_.front().zero_counts);
  });
  restoreZeros();
  patient_.start();
  urgent_.start();
  bus_ = std::thread(&HardwareDriverNode::runBus, this);
}

HardwareDriverNode::~HardwareDriverNode() {
  running_ = false;
  patient_.stop();
  urgent_.stop();
  wake_up_.signal();
  bus_.join();
}

void HardwareDriverNode::advertiseVerb(ServiceLane& lane, const std::string& verb, DriverRequest request) {
  lane.advertise(verb, [this, &lane, verb, request](std_srvs::Trigger::Response& response) {
    onVerb(lane, verb, request, response);
  });
}

void HardwareDriverNode::restoreZeros() {
  const std::map<std::string, double> zeros = zeros_.take();
  for (std::size_t i = 0; i < message_.name.size(); ++i) {
    const auto zero = zeros.find(message_.name[i]);
    if (zero != zeros.end()) driver_.restoreZero(static_cast<int>(i), zero->second);
  }
}

// --- Callbacks ---

void HardwareDriverNode::onCommand(const ActuatorCommand::ConstPtr& message) {
  const Command command = reader_.read(message->session, message->sequence, message->status, message->name,
                                       message->mode, message->value, message->effort, Clock::now());
  if (!commands_.push(command)) ++overruns_;
  wake_up_.signal();
}

// Hands a request to the bus thread; whether it was taken.
bool HardwareDriverNode::hand(DriverRequest request) {
  const std::lock_guard<std::mutex> lock(request_mutex_);
  answer_ = Answer::kWaiting;
  request_ = static_cast<int>(request);
  wake_up_.signal();
  while (answer_ == Answer::kWaiting && running_) ros::WallDuration(0.001).sleep();
  return answer_ == Answer::kTaken;
}

void HardwareDriverNode::onVerb(ServiceLane& lane, const std::string& verb, DriverRequest request,
                                std_srvs::Trigger::Response& response) {
  const bool taken = hand(request);
  const bool settled = taken && settle(lane, request);
  lane.reports.update();
  const DriverReport& report = lane.reports.front();
  const std::string state = name(report.state) + (report.reason.empty() ? "" : ": " + report.reason) +
                            (report.emergency_stop ? "; the emergency stop is pressed" : "");
  const bool nothing_to_do = request == DriverRequest::kRecover && !taken && takesCommands(report.state);
  response.success = settled || nothing_to_do;
  response.message = taken           ? state
                     : nothing_to_do ? "nothing to recover from: " + state
                                     : verb + " is not possible now (" + state + ")";
}

// Waits until the request has led where it should, or elsewhere.
bool HardwareDriverNode::settle(ServiceLane& lane, DriverRequest request) {
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(kServiceTimeout);
  for (; running_ && ros::WallTime::now() < deadline; ros::WallDuration(0.005).sleep()) {
    lane.reports.update();
    const DriverReport& report = lane.reports.front();
    if (report.state == DriverState::kInitialising || report.relaxing) continue;
    if (request == DriverRequest::kHalt) return report.state == DriverState::kSafe;
    if (request == DriverRequest::kEmergency) return isSafe(report.state);
    if (request == DriverRequest::kShutdown) return report.state == DriverState::kOff;
    return takesCommands(report.state);
  }
  return false;
}

// --- The bus thread ---

void HardwareDriverNode::runBus() {
  raisePriority(kCyclePriority);
  Time last = Clock::now();
  bool commanded = false;
  while (running_) {
    waitForCycle(last, commanded);
    commanded = takeInputs();
    last = Clock::now();
    const DriverReport& report = driver_.update(last);
    writeForServices(report);
    for_diagnostics_.write(report);
    publish(report);
  }
}

void HardwareDriverNode::writeForServices(const DriverReport& report) {
  patient_.reports.write(report);
  urgent_.reports.write(report);
}

void HardwareDriverNode::waitForCycle(Time last, bool commanded) {
  const double period = 1 / description_.rate;
  wake_up_.waitUntil(last + duration(period * (commanded ? kLatestCycle : 1)));
  std::this_thread::sleep_until(last + duration(period * kEarliestCycle));
}

// Returns whether a command came.
bool HardwareDriverNode::takeInputs() {
  driver_.setEmergencyStop(emergency_stops_.pressed());
  const int request = request_.exchange(kNoRequest);
  if (request != kNoRequest) {
    auto_init_ = false;
    const bool taken = driver_.request(static_cast<DriverRequest>(request));
    writeForServices(driver_.report());  // the outcome must not be read from a report of before
    answer_ = taken ? Answer::kTaken : Answer::kRefused;
  }
  retryInit();
  Command command;
  bool any = false;
  for (; commands_.pop(command); any = true) driver_.offer(command);
  return any;
}

// A simulated port may appear later than this node: try until the robot has been ready once.
void HardwareDriverNode::retryInit() {
  const DriverState state = driver_.report().state;
  if (takesCommands(state)) auto_init_ = false;
  const bool idle = state == DriverState::kOff || state == DriverState::kFault;
  if (!auto_init_ || !idle || Clock::now() - last_attempt_ < duration(kRetryPeriod)) return;
  last_attempt_ = Clock::now();
  driver_.request(DriverRequest::kRecover);
}

void HardwareDriverNode::publish(const DriverReport& report) {
  const std::size_t size = report.actuators.size();
  for (auto* values : {&message_.measured, &message_.effort, &message_.current, &message_.temperature})
    values->resize(size);
  message_.measured_valid.resize(size);
  message_.zero_valid.resize(size);
  message_.fault.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    const ActuatorReading& actuator = report.actuators[i];
    message_.measured[i] = actuator.measured;
    message_.measured_valid[i] = actuator.valid;
    message_.effort[i] = actuator.effort;
    message_.current[i] = actuator.current;
    message_.temperature[i] = actuator.temperature;
    message_.zero_valid[i] = actuator.zero_valid;
    message_.fault[i] = actuator.fault;
  }
  message_.header.stamp = ros::Time::now();
  message_.applied = report.applied;
  message_.emergency_stop = report.emergency_stop;
  message_.driver_state = static_cast<std::uint8_t>(report.state);
  message_.reason = report.reason;
  message_.command_age = report.command_age;
  message_.session = report.session;
  message_.sequence = report.sequence;
  message_.accepted = report.commands.accepted;
  message_.rejected_session = report.commands.session;
  message_.rejected_sequence = report.commands.sequence;
  message_.rejected_malformed = report.commands.malformed;
  message_.rejected_not_finite = report.commands.not_finite;
  message_.rejected_state = report.commands.state;
  message_.bus_corrupted = report.bus.corrupted;
  message_.bus_missing = report.bus.missing;
  message_.bus_device_error = report.bus.device_error;
  state_.publish(message_);
}

// --- The rest ---

void HardwareDriverNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Status = diagnostic_msgs::DiagnosticStatus;
  for_diagnostics_.update();
  const DriverReport& report = for_diagnostics_.front();
  const bool bad = report.state == DriverState::kFault;
  const bool well = takesCommands(report.state) && report.state != DriverState::kHolding;
  const std::string reason = report.reason.empty() ? "" : ": " + report.reason;
  status.summary(bad ? Status::ERROR : well ? Status::OK : Status::WARN, name(report.state) + reason);
  status.add("ports", listPorts(description_));
  status.add("emergency stop", report.emergency_stop ? "pressed" : "free");
  status.add("cycles", report.cycles);
  status.add("commands accepted", report.commands.accepted);
  status.add("commands refused: session", report.commands.session);
  status.add("commands refused: sequence", report.commands.sequence);
  status.add("commands refused: malformed", report.commands.malformed);
  status.add("commands refused: not finite", report.commands.not_finite);
  status.add("commands refused: state", report.commands.state);
  status.add("commands refused: no room", overruns_.load());
  status.add("packets corrupted", report.bus.corrupted);
  status.add("packets missing", report.bus.missing);
  status.add("packets stale", report.bus.stale);
  status.add("packets with device error", report.bus.device_error);
  for (std::size_t i = 0; i < report.actuators.size(); ++i) {
    const ActuatorReading& actuator = report.actuators[i];
    const bool pressure = description_.actuators[i].quantity == Quantity::kPressure;
    status.addf(
        message_.name[i],
        pressure ? "%.1f V, %.0f degC, %.0f Pa, zero %s, fault 0x%X" : "%.1f V, %.0f degC, %.1f N, zero %s, fault 0x%X",
        actuator.voltage, actuator.temperature, actuator.effort, actuator.zero_valid ? "valid" : "unknown",
        actuator.fault);
  }
}

void HardwareDriverNode::shutDown() {
  request_ = static_cast<int>(DriverRequest::kShutdown);
  wake_up_.signal();
  const double limit = description_.relax_time + kSwitchOffTime;
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(limit);
  patient_.stop();
  urgent_.stop();
  for (; ros::WallTime::now() < deadline; ros::WallDuration(0.01).sleep()) {
    urgent_.reports.update();
    const DriverReport& report = urgent_.reports.front();
    if (request_ == kNoRequest && report.state == DriverState::kOff && !report.relaxing) return;
  }
  ROS_WARN("the actuators could not be switched off; their own watchdogs stop them");
}

}  // namespace sinew

namespace {

volatile sig_atomic_t stop_asked = 0;

void askToStop(int) {
  stop_asked = 1;
}

}  // namespace

int main(int argc, char** argv) {
  // Before ros::init: the threads that roscpp starts inherit it.
  const std::string not_allowed = sinew::requestRealTime();
  // Publishing must go on while the actuators relax, so roscpp does not handle the signal.
  ros::init(argc, argv, "hardware_driver", ros::init_options::NoSigintHandler);
  signal(SIGINT, askToStop);
  signal(SIGTERM, askToStop);
  try {
    sinew::HardwareDriverNode driver{ros::NodeHandle(), ros::NodeHandle("~")};
    if (!not_allowed.empty()) ROS_WARN_STREAM("not in real time: " << not_allowed << "; cycles may be late");
    while (ros::ok() && stop_asked == 0) ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
    driver.shutDown();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
