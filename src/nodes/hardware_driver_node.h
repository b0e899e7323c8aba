#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <sinew/ActuatorCommand.h>
#include <sinew/ActuatorState.h>

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "emergency_stops.h"
#include "hardware_driver_wake_up.h"
#include "service_lane.h"
#include "sinew/common/newest_wins.h"
#include "sinew/hardware/command_queue.h"
#include "sinew/hardware/hardware_driver.h"
#include "zero_file.h"

namespace sinew {

/// Carries commands to the devices and their state back.
///
/// Three threads: callbacks of commands and diagnostics; services, which may wait for their outcome; and the buses,
/// whose thread alone touches the driver and publishes after every cycle. A command wakes it at once, but no earlier
/// than half a period after its last cycle; without commands it runs at its own rate.
class HardwareDriverNode {
 public:
  /// Throws ConfigError for wrong parameters.
  HardwareDriverNode(ros::NodeHandle node, ros::NodeHandle private_node);
  ~HardwareDriverNode();

  /// Relaxes the actuators and switches them off; returns when they are, or after a while when they cannot be reached.
  void shutDown();

 private:
  static constexpr int kNoRequest = -1;
  enum class Answer { kWaiting, kRefused, kTaken };

  void advertiseVerb(ServiceLane& lane, const std::string& verb, DriverRequest request);
  bool hand(DriverRequest request);
  void onCommand(const ActuatorCommand::ConstPtr& message);
  void onVerb(ServiceLane& lane, const std::string& verb, DriverRequest request, std_srvs::Trigger::Response& response);
  bool settle(ServiceLane& lane, DriverRequest request);
  void restoreZeros();
  void runBus();
  void writeForServices(const DriverReport& report);
  void waitForCycle(Time last, bool commanded);
  bool takeInputs();
  void retryInit();
  void publish(const DriverReport& report);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  HardwareDescription description_;
  bool auto_init_;
  HardwareDriver driver_;
  CommandReader reader_;
  ZeroFile zeros_;
  CommandQueue commands_;
  WakeUp wake_up_;
  std::atomic<int> request_{kNoRequest};
  std::atomic<Answer> answer_{Answer::kWaiting};
  std::atomic<std::uint64_t> overruns_{0};
  std::atomic<bool> running_{true};
  Time last_attempt_{};
  NewestWins<DriverReport> for_diagnostics_;

  ros::NodeHandle node_;
  ServiceLane patient_;  // what may take its time
  ServiceLane urgent_;   // what must not wait for that
  std::mutex request_mutex_;
  ros::Publisher state_;
  ActuatorState message_;
  ros::Subscriber command_;
  diagnostic_updater::Updater diagnostics_;
  ros::WallTimer diagnostics_timer_;
  EmergencyStops emergency_stops_;
  std::thread bus_;
};

}  // namespace sinew
