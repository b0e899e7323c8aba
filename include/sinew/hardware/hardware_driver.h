#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/actuator_watch.h"
#include "sinew/hardware/cable_homing.h"
#include "sinew/hardware/command_gate.h"
#include "sinew/hardware/command_limiter.h"
#include "sinew/hardware/device_bus.h"
#include "sinew/hardware/driver_state.h"
#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/release_ramp.h"

namespace sinew {

/// What a user may ask of the driver.
enum class DriverRequest {
  kInit,       ///< connect, home everything, switch on
  kHome,       ///< home again, from ready
  kRecover,    ///< the same, but zeros that are still valid are kept; or leave holding, safe or fault
  kHalt,       ///< stop where it is, latched
  kEmergency,  ///< every actuator into its behaviour of on_timeout, latched
  kShutdown    ///< relax and switch off
};

/// Everything the driver knows after a cycle.
struct DriverReport {
  DriverState state = DriverState::kOff;
  std::string reason;                      ///< why it is in this state
  std::vector<ActuatorReading> actuators;  ///< in the order of the description
  std::vector<double> applied;             ///< m or Pa, set points after the driver's own limits
  std::vector<double> zero_counts;         ///< DeviceBus::zeroCounts, where the zero is valid
  double command_age = -1;                 ///< s since the last accepted command, -1 before the first
  std::uint32_t session = 0;               ///< 0 while any session may come
  std::uint32_t sequence = 0;
  CommandGate::Counters commands;
  BusCounters bus;
  std::uint64_t cycles = 0;
  bool relaxing = false;        ///< some actuator is giving its effort away
  bool emergency_stop = false;  ///< pressed; nothing leaves a latched state meanwhile
};

/// The driver without ROS: one owner of devices, limits and safety state. One thread calls everything; one `update()`
/// is one cycle of all buses, write and read.
class HardwareDriver {
 public:
  HardwareDriver(const HardwareDescription& description, std::unique_ptr<DeviceBus> devices);

  /// Returns whether the request leads anywhere from the present state; the outcome shows in the reports that follow.
  bool request(DriverRequest request);

  /// Before the first request: see DeviceBus::restoreZero.
  void restoreZero(int actuator, double counts) { devices_->restoreZero(actuator, counts); }

  /// Says whether an emergency stop is pressed. Letting go of it moves nothing: `recover` does.
  void setEmergencyStop(bool pressed);

  /// Takes a command or refuses it; the next `update()` applies it.
  CommandVerdict offer(const Command& command);

  /// One cycle at `now`, by the clock of the commands' times of receipt.
  const DriverReport& update(Time now);

  const DriverReport& report() const { return report_; }

 private:
  enum class SetUp { kOpen, kConfigure, kFirstReading, kHoming };

  bool handle(DriverEvent event, const std::string& reason);
  void enter(DriverState state, DriverEvent event);
  bool mayFollow(const Command& command);
  void follow(const Command& command);
  void checkCommands(Time now);
  void serve(Time now, double interval);
  bool exchange(const std::vector<double>& set_points, Time now);
  bool checkHealth();
  void fail(std::size_t actuator, std::uint32_t fault);
  void lose(const std::string& reason);
  void startRelease(bool all);
  void updateRelease(Time now);
  void updateInitialising(Time now, double interval);
  void openLines();
  void takeFirstReading(Time now);
  void updateHoming(double interval, Time now);
  void finishHoming();
  void updateIdle(Time now);
  void probe(Time now);
  void fillReport(Time now);

  HardwareDescription description_;
  std::unique_ptr<DeviceBus> devices_;
  CommandLimiter limiter_;
  CommandGate gate_;
  CableHoming homing_;
  ActuatorWatch watch_;
  ReleaseRamp release_;
  DriverState state_ = DriverState::kOff;
  SetUp set_up_ = SetUp::kOpen;
  bool home_all_ = true;
  std::vector<bool> keep_zero_;
  std::vector<double> target_;                    // m or Pa
  std::vector<double> measured_;                  // m or Pa
  std::array<double, kMaxActuators> expected_{};  // N
  CommandStatus last_status_ = CommandStatus::kOk;
  Time held_since_{};  // first of the held commands in a row
  Time holding_since_{};
  Time last_update_{};
  Time last_probe_{};
  bool any_update_ = false;
  DriverReport report_;
};

}  // namespace sinew
