#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <string>

#include "actuator_inbox.h"
#include "body_publisher.h"
#include "callback_thread.h"
#include "control_cycle.h"
#include "control_mode.h"
#include "control_report.h"
#include "control_session.h"
#include "control_settings.h"
#include "cycle_publisher.h"
#include "enabling.h"
#include "frame_finder.h"
#include "obstacle_inbox.h"
#include "target_inbox.h"

namespace sinew {

/// One inverse controller on the wire. Threads meet here that never wait for each other:
///  - the cycle thread, by the steady clock, owns the controller while it follows or controls;
///  - the callback threads fill the inboxes, the publishers' threads empty what the cycle hands over;
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
  // Service thread.
  using Trigger = std_srvs::Trigger;
  bool onEnable(Trigger::Request& request, Trigger::Response& response);
  bool onDisable(Trigger::Request& request, Trigger::Response& response);
  bool onReset(Trigger::Request& request, Trigger::Response& response);
  void onAutoEnable(const ros::SteadyTimerEvent& event);
  void onDiagnostics(const ros::SteadyTimerEvent& event);

  ControlSettings settings_;
  std::shared_ptr<const RobotModel> robot_;
  FrameFinder frames_;
  TargetInbox targets_;
  ObstacleInbox obstacles_;
  ActuatorInbox actuators_;
  BodyPublisher body_;
  ControlMode mode_;
  ControlSession session_;
  CyclePublisher publisher_;
  ControlCycle cycle_;
  Enabling enabling_;
  ControlReport report_;
  std::string refused_to_enable_;
  ros::CallbackQueue service_queue_;
  CallbackThread service_thread_;
  diagnostic_updater::Updater diagnostics_;
  ros::ServiceServer enable_service_, disable_service_, reset_service_;
  ros::SteadyTimer auto_enable_timer_, diagnostics_timer_;
};

}  // namespace sinew
