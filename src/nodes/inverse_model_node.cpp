#include "inverse_model_node.h"

#include <ros/console.h>

#include "sinew/robot/robot_description.h"

namespace sinew {

namespace {

constexpr double kAutoEnablePeriod = 0.5;  // s

std::shared_ptr<const RobotModel> readRobot(const Parameters& parameters) {
  auto robot = std::make_shared<RobotModel>(readRobotDescription(parameters.text("robot")));
  for (const std::string& warning : robot->warnings()) ROS_WARN_STREAM(robot->description().name << ": " << warning);
  return robot;
}

}  // namespace

InverseModelNode::InverseModelNode(ros::NodeHandle node, ros::NodeHandle private_node)
    : settings_(Parameters(private_node)),
      robot_(readRobot(Parameters(private_node))),
      frames_(node, robot_->description().frame, settings_.transform_tolerance),
      targets_(node, Parameters(private_node), robot_, frames_),
      obstacles_(node, "tracked_obstacles", settings_.obstacles, robot_, frames_),
      actuators_(node, robot_),
      body_(node, robot_),
      mode_(settings_.period()),
      session_(robot_, settings_.period()),
      publisher_(node, {settings_.rate, settings_.priority}, robot_, session_.input, session_.output),
      cycle_(settings_, robot_, {targets_, obstacles_, actuators_}, mode_, session_, publisher_, body_),
      enabling_(settings_, robot_, actuators_, targets_, mode_, session_),
      report_(mode_, targets_, obstacles_, actuators_, publisher_.summary()),
      service_thread_(service_queue_),
      diagnostics_(node, private_node) {
  diagnostics_.setHardwareID(robot_->description().name);
  report_.addTo(diagnostics_);
  private_node.setCallbackQueue(&service_queue_);
  enable_service_ = private_node.advertiseService("enable", &InverseModelNode::onEnable, this);
  disable_service_ = private_node.advertiseService("disable", &InverseModelNode::onDisable, this);
  reset_service_ = private_node.advertiseService("reset", &InverseModelNode::onReset, this);
  diagnostics_timer_ = private_node.createSteadyTimer(ros::WallDuration(1), &InverseModelNode::onDiagnostics, this);
  if (settings_.auto_enable) {
    auto_enable_timer_ =
        private_node.createSteadyTimer(ros::WallDuration(kAutoEnablePeriod), &InverseModelNode::onAutoEnable, this);
  }
  cycle_.start();
  service_thread_.start();
}

// Services wait for cycles.
InverseModelNode::~InverseModelNode() {
  service_thread_.stop();
}

bool InverseModelNode::onEnable(Trigger::Request&, Trigger::Response& response) {
  const std::string refusal = enabling_.enable();
  response.success = refusal.empty();
  response.message = refusal.empty() ? "enabled" : refusal;
  return true;
}

bool InverseModelNode::onDisable(Trigger::Request&, Trigger::Response& response) {
  enabling_.disable();
  response.success = true;
  response.message = "disabled";
  return true;
}

bool InverseModelNode::onReset(Trigger::Request&, Trigger::Response& response) {
  enabling_.reset();
  response.success = true;
  response.message = "disabled, the model is at rest and the targets are forgotten";
  return true;
}

void InverseModelNode::onAutoEnable(const ros::SteadyTimerEvent&) {
  if (mode_.enabled()) return;
  const std::string refusal = enabling_.enable();
  if (refusal == refused_to_enable_) return;
  refused_to_enable_ = refusal;
  if (refusal.empty()) {
    ROS_INFO("enabled");
  } else {
    ROS_INFO_STREAM("not enabled yet: " << refusal);
  }
}

void InverseModelNode::onDiagnostics(const ros::SteadyTimerEvent&) {
  report_.update();
  diagnostics_.force_update();
}

}  // namespace sinew
