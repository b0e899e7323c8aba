#include "bus_session.h"

#include <signal.h>

#include <algorithm>
#include <limits>
#include <thread>

#include "sinew/hardware/device_factory.h"
#include "sinew/hardware/port_opener.h"

namespace sinew {
namespace {

constexpr double kSwitchOffTime = 2;  // s beyond relax_time
constexpr std::uint32_t kSession = 1;

volatile sig_atomic_t stop_asked = 0;

void askToStop(int) {
  stop_asked = 1;
}

}  // namespace

void catchStops() {
  signal(SIGINT, askToStop);
  signal(SIGTERM, askToStop);
}

bool isStopAsked() {
  return stop_asked != 0;
}

HardwareDescription select(const HardwareDescription& hardware, const std::vector<int>& which) {
  HardwareDescription selected = hardware;
  selected.buses.clear();
  selected.actuators.clear();
  std::vector<int> number(hardware.buses.size(), -1);
  for (const int i : which) {
    ActuatorDescription actuator = hardware.actuators[static_cast<std::size_t>(i)];
    const auto bus = static_cast<std::size_t>(actuator.bus);
    if (number[bus] < 0) {
      number[bus] = static_cast<int>(selected.buses.size());
      selected.buses.push_back(hardware.buses[bus]);
    }
    actuator.bus = number[bus];
    selected.actuators.push_back(actuator);
  }
  return selected;
}

void homeWhereFound(HardwareDescription& hardware) {
  for (ActuatorDescription& actuator : hardware.actuators) actuator.cable.homing = HomingDescription();
}

BusSession::BusSession(const HardwareDescription& hardware)
    : hardware_(hardware),
      driver_(hardware, makeBusGroup(hardware, makePortOpener())),
      emergency_stop_(hardware.emergency_stop.input),
      next_(Clock::now()) {}

void BusSession::lookAtEmergencyStop() {
  if (hardware_.emergency_stop.input.empty()) return;
  emergency_stop_.update(Duration{0});
  driver_.setEmergencyStop(emergency_stop_.pressed());
}

bool BusSession::setUp() {
  lookAtEmergencyStop();
  driver_.request(DriverRequest::kInit);
  while (!isStopAsked() && cycle().state == DriverState::kInitialising) {
  }
  return report().state == DriverState::kReady;
}

std::string BusSession::whyNot() const {
  if (isStopAsked()) return "stopped";
  return report().emergency_stop ? "the emergency stop is pressed, or its device cannot be read" : report().reason;
}

const DriverReport& BusSession::cycle() {
  std::this_thread::sleep_until(next_);
  cycleNow();
  next_ = std::max(next_ + duration(period()), Clock::now());
  return report();
}

const DriverReport& BusSession::cycleNow() {
  lookAtEmergencyStop();
  return driver_.update(Clock::now());
}

void BusSession::command(const std::vector<double>& set_points) {
  Command command;
  command.defect = CommandVerdict::kAccepted;
  command.session = kSession;
  command.sequence = ++sequence_;
  command.received = Clock::now();
  command.effort.fill(std::numeric_limits<double>::quiet_NaN());
  std::copy(set_points.begin(), set_points.end(), command.value.begin());
  driver_.offer(command);
}

void BusSession::letGo() {
  if (report().state == DriverState::kOff && !report().relaxing) return;
  driver_.request(DriverRequest::kShutdown);
  const Time deadline = Clock::now() + duration(hardware_.relax_time + kSwitchOffTime);
  while (Clock::now() < deadline && report().relaxing) cycle();
  cycle();  // closes the lines
}

}  // namespace sinew
