#include "bus_session.h"

#include <signal.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <thread>

#include "sinew/hardware/device_factory.h"
#include "sinew/hardware/port_opener.h"
#include "zero_file.h"

namespace sinew {
namespace {

constexpr double kSwitchOffTime = 2;  // s beyond relax_time
constexpr std::uint32_t kSession = 1;

volatile sig_atomic_t stop_asked = 0;

void askToStop(int) {
  stop_asked = 1;
}

// Whether the zeros in a file are of any of these; one that cannot be read may be of all.
bool namesAny(const std::string& path, const std::vector<std::string>& actuators) {
  try {
    const YAML::Node zeros = YAML::LoadFile(path);
    return std::any_of(actuators.begin(), actuators.end(),
                       [&](const std::string& name) { return static_cast<bool>(zeros[name]); });
  } catch (const YAML::Exception&) {
    return true;
  }
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

void forgetZeros(const std::vector<std::string>& actuators) {
  const std::filesystem::path folder = std::filesystem::path(makeZeroPath("")).parent_path();
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const std::string file = entry.path().filename().string();
    if (file.rfind("sinew_zeros", 0) != 0 || !namesAny(entry.path().string(), actuators)) continue;
    std::filesystem::remove(entry.path(), none);
    std::printf("%s is removed: the driver homes again at its next start\n", entry.path().c_str());
  }
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
  forgetZeros(hardware_.names());
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
