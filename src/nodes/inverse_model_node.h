#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "actuator_inbox.h"
#include "applied_estimate.h"
#include "body_publisher.h"
#include "callback_thread.h"
#include "frame_finder.h"
#include "obstacle_inbox.h"
#include "parameters.h"
#include "real_time.h"
#include "sinew/inverse/inverse_controller.h"
#include "stage_statistics.h"
#include "target_inbox.h"

namespace sinew {

/// One inverse controller on the wire. Three kinds of threads meet here and never wait for each other:
///  - the cycle thread, by the steady clock, owns the controller while it follows or controls;
///  - the callback threads fill the inboxes;
///  - the service thread enables, disables and reports. To move the model it parks the cycle, which then runs on
///    without touching the controller.
class InverseModelNode {
 public:
  /// Throws ConfigError when a parameter or the robot is not right.
  InverseModelNode(ros::NodeHandle node, ros::NodeHandle private_node);
  ~InverseModelNode();
  InverseModelNode(const InverseModelNode&) = delete;
  InverseModelNode& operator=(const InverseModelNode&) = delete;

 private:
  enum class Mode {
    kFollowing,   ///< disabled: the model follows what the driver measures
    kParked,      ///< disabled: the controller belongs to the service thread
    kControlling  ///< enabled
  };

  struct Settings {
    explicit Settings(const Parameters& parameters);
    double rate;                 // Hz
    double body_state_rate;      // Hz
    double driver_timeout;       // s
    double transform_tolerance;  // s
    ObstacleInbox::Settings obstacles;
    bool require_driver;
    bool auto_enable;
    int priority;
  };

  /// What the service thread reports of the cycles.
  struct Summary {
    std::uint8_t status = ControllerState::DISABLED;
    std::uint64_t cycle = 0, deadline_misses = 0;
    std::array<std::uint64_t, 4> held{};  ///< cycles held, by HoldReason; none: for a lost obstacle
    double median = 0, maximum = 0;       ///< s, of a whole cycle over the last second
  };

  // Cycle thread.
  void runCycles();
  void runCycle(double begin);
  void follow();
  void rest(const char* reason);
  void control();
  void readInbox();
  void updateTargets();
  void updateObstacles();
  void holdForObstacle();
  const char* findReasonToStop();
  bool isDriverFresh(const ActuatorReading& reading, double now) const;
  void holdIfNotFinite();
  void publishCommand(const ros::Time& stamp);
  void publishState(const ros::Time& stamp);
  void updateInputStamps();
  void updateSummary();

  // Service thread.
  using Trigger = std_srvs::Trigger;
  bool onEnable(Trigger::Request& request, Trigger::Response& response);
  bool onDisable(Trigger::Request& request, Trigger::Response& response);
  bool onReset(Trigger::Request& request, Trigger::Response& response);
  void onAutoEnable(const ros::SteadyTimerEvent& event);
  void onDiagnostics(const ros::SteadyTimerEvent& event);
  std::string enable();
  std::string findReasonNotToEnable(const ActuatorReading& reading) const;
  std::string resynchronise(const VecX& measured);
  std::string compareFirstCommand(const VecX& measured) const;
  void park();
  void release(Mode mode, const char* reason);
  void waitUntilParked(bool parked) const;
  void reportControl(diagnostic_updater::DiagnosticStatusWrapper& status);
  void reportInputs(diagnostic_updater::DiagnosticStatusWrapper& status);
  void reportObstacles(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle node_;
  Settings settings_;
  std::shared_ptr<const RobotModel> robot_;
  FrameFinder frames_;
  TargetInbox targets_;
  ObstacleInbox obstacles_;
  ActuatorInbox actuators_;
  BodyPublisher body_;

  std::atomic<Mode> wanted_{Mode::kFollowing};
  std::atomic<Mode> granted_{Mode::kFollowing};
  std::atomic<const char*> disabled_reason_{"not enabled yet"};

  // Belongs to the cycle thread, or to the service thread while parked.
  InverseController controller_;
  CycleInput input_;
  CycleOutput output_;
  AppliedEstimate applied_;
  VecX followed_;             // m, where the disabled model is
  VecX last_command_;         // m
  bool with_driver_ = false;  // this session needs one
  std::uint32_t session_ = 0;
  std::uint32_t sequence_ = 0;
  double enabled_since_ = 0;  // s, steady

  // Cycle thread only.
  PeriodicWakeUp wake_up_;
  StageStatistics statistics_;
  ActuatorCommand command_;
  ControllerState state_;
  std::vector<std::string> lost_words_;  // per obstacle
  int lost_ = -1;                        // obstacle, -1 for none
  double last_begin_ = -1;               // s, steady
  std::uint64_t cycle_ = 0, deadline_misses_ = 0;
  std::array<std::uint64_t, 4> held_{};
  std::uint64_t body_divider_, statistics_divider_;
  NewestWins<Summary> summary_;
  ros::Publisher command_publisher_, state_publisher_;

  // Service thread only.
  ros::CallbackQueue service_queue_;
  CallbackThread service_thread_;
  diagnostic_updater::Updater diagnostics_;
  Summary reported_;        // as of the last diagnostics
  double reported_at_ = 0;  // s, steady
  std::uint64_t reported_target_refusals_ = 0, reported_driver_refusals_ = 0;
  std::uint64_t reported_obstacle_refusals_ = 0, reported_outliers_ = 0;
  std::string refused_to_enable_;
  ros::ServiceServer enable_service_, disable_service_, reset_service_;
  ros::SteadyTimer auto_enable_timer_, diagnostics_timer_;

  std::atomic<bool> stop_{false};
  std::thread cycle_thread_;
};

}  // namespace sinew
