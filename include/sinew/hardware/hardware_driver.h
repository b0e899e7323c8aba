#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/cable_homing.h"
#include "sinew/hardware/command_gate.h"
#include "sinew/hardware/command_limiter.h"
#include "sinew/hardware/driver_state.h"
#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/servo_chain.h"

namespace sinew {

/// What a user may ask of the driver.
enum class DriverRequest {
  kInit,     ///< connect, home, switch on
  kHome,     ///< home again, from ready
  kRecover,  ///< leave holding, safe or fault
  kHalt,     ///< stop where it is, latched
  kShutdown  ///< relax and switch off
};

/// Everything the driver knows after a cycle.
struct DriverReport {
  DriverState state = DriverState::kOff;
  std::string reason;                ///< why it is in this state
  std::vector<ServoReading> servos;  ///< in the order of the description
  std::vector<double> applied;       ///< m, set points after the driver's own limits
  double command_age = -1;           ///< s since the last accepted command, -1 before the first
  std::uint32_t session = 0;         ///< 0 while any session may come
  std::uint32_t sequence = 0;
  CommandGate::Counters commands;
  BusCounters bus;
  std::uint64_t cycles = 0;
  bool relaxing = false;  ///< some actuator is giving its tension away
};

/// Opens the line to the devices; returns nothing, and says why in `why`, when it cannot.
using LineFactory = std::function<std::shared_ptr<ByteStream>(std::string& why)>;

/// The driver without ROS: one owner of line, servos, limits and safety state. One thread calls everything; one
/// `update()` is one bus cycle, write and read.
class HardwareDriver {
 public:
  HardwareDriver(const HardwareDescription& description, LineFactory open_line);

  /// Returns whether the request leads anywhere from the present state; the outcome shows in the reports that follow.
  bool request(DriverRequest request);

  /// Takes a command or refuses it; the next `update()` applies it.
  CommandVerdict offer(const Command& command);

  /// One cycle at `now`, by the clock of the commands' times of receipt.
  const DriverReport& update(Time now);

  const DriverReport& report() const { return report_; }

 private:
  enum class SetUp { kOpen, kConfigure, kFirstReading, kHoming };
  struct Release {
    bool active = false;
    bool started = false;
    Time start{};
    std::vector<bool> which;
    std::vector<double> tension;  // N, at the start
  };

  bool handle(DriverEvent event, const std::string& reason);
  void enter(DriverState state, DriverEvent event);
  bool mayFollow(const Command& command);
  void startRelease(bool all);
  void updateRelease(Time now);
  void updateInitialising(Time now, double interval);
  void openLine();
  void updateHoming(double interval, Time now);
  void finishHoming();
  void serve(Time now, double interval);
  void checkCommands(Time now);
  void updateIdle(Time now);
  void probe(Time now);
  void lose(const std::string& reason);
  bool checkLine(bool usable);
  void fillReport(Time now);

  HardwareDescription description_;
  LineFactory open_line_;
  std::shared_ptr<ByteStream> line_;
  ServoChain chain_;
  CommandLimiter limiter_;
  CommandGate gate_;
  CableHoming homing_;
  DriverState state_ = DriverState::kOff;
  SetUp set_up_ = SetUp::kOpen;
  bool home_all_ = true;
  std::vector<bool> keep_zero_;
  std::vector<double> target_;
  std::vector<double> tension_limits_;
  std::vector<double> measured_;
  Release release_;
  CommandStatus last_status_ = CommandStatus::kOk;
  Time held_since_{};  // first of the held commands in a row
  Time holding_since_{};
  Time last_update_{};
  Time last_probe_{};
  bool any_update_ = false;
  DriverReport report_;
};

}  // namespace sinew
