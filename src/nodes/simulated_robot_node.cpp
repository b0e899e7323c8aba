// Stands in for the robot: its devices on pseudo-terminals, a body of finite elements that they pull at, and a tracker.

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PoseStamped.h>
#include <ros/ros.h>
#include <sinew/BodyState.h>
#include <sinew/ContactArray.h>
#include <sinew/EffectorTargets.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "callback_thread.h"
#include "parameters.h"
#include "real_time.h"
#include "ros_conversions.h"
#include "simulated_devices.h"
#include "simulated_robot_node_load.h"
#include "simulated_robot_node_obstacles.h"
#include "simulated_robot_node_plant.h"
#include "simulated_robot_node_settings.h"
#include "simulated_robot_node_tracker.h"
#include "sinew/common/newest_wins.h"

namespace sinew {
namespace {

constexpr double kDevicePeriod = 0.002;  // s

geometry_msgs::Pose makePose(const VecX& effectors, size_t effector) {
  geometry_msgs::Pose pose;
  pose.position = toPoint(effectors.segment<3>(3 * static_cast<Eigen::Index>(effector)));
  pose.orientation.w = 1;
  return pose;
}

SimulatedPlant makePlant(const SimulatedRobotSettings& settings) {
  const NormalPriority while_settling;
  return {settings.robot, settings.deviations};
}

std::unique_ptr<SimulatedObstacles> makeObstacles(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot) {
  const std::vector<Obstacle>& obstacles = robot->obstacles();
  const bool tracked = std::any_of(obstacles.begin(), obstacles.end(), [](const Obstacle& o) { return o.tracked; });
  return tracked ? std::make_unique<SimulatedObstacles>(node, std::move(robot)) : nullptr;
}

class SimulatedRobotNode {
 public:
  SimulatedRobotNode(ros::NodeHandle node, ros::NodeHandle private_node, const SimulatedRobotSettings& settings)
      : settings_(settings),
        plant_(makePlant(settings)),
        devices_(node, private_node, settings.hardware, settings.line),
        reeled_in_(VecX::Zero(static_cast<Eigen::Index>(settings.winches.size()))),
        tension_(VecX::Zero(static_cast<Eigen::Index>(settings.winches.size()))),
        tracker_(settings.tracker),
        node_(node),
        obstacles_(makeObstacles(node, plant_.sharedRobot())),
        diagnostics_(node, private_node) {
    advertise();
    device_thread_ = std::thread([this] { moveDevices(); });
    body_thread_ = std::thread([this] { moveBody(); });
  }

  ~SimulatedRobotNode() {
    running_ = false;
    body_thread_.join();
    device_thread_.join();
  }

 private:
  void advertise() {
    const RobotDescription& description = plant_.robot().description();
    effectors_message_.header.frame_id = description.frame;
    for (const EffectorDescription& effector : description.effectors) {
      effectors_message_.name.push_back(effector.name);
      tracked_.push_back(node_.advertise<geometry_msgs::PoseStamped>("tracker/" + effector.name, 10));
    }
    effectors_message_.pose.resize(effectors_message_.name.size());
    effectors_ = node_.advertise<EffectorTargets>("plant/effectors", 10);
    body_message_ = makeBodyMessage(plant_.robot());
    body_ = node_.advertise<BodyState>("plant/body_state", 2);
    contacts_message_.header.frame_id = description.frame;
    part_owners_ = listPartOwners(plant_.robot());
    contacts_ = node_.advertise<ContactArray>("plant/contacts", 10);
    diagnostics_.setHardwareID("simulated");
    diagnostics_.add("simulated robot", this, &SimulatedRobotNode::diagnose);
    diagnostics_timer_ = node_.createWallTimer(ros::WallDuration(0.2), [this](const ros::WallTimerEvent&) {
      diagnostics_.update();  // once a second at most
    });
  }

  void moveDevices() {
    PeriodicWakeUp wake_up(kDevicePeriod);
    SimulatedHardware& hardware = devices_.hardware();
    double moved_until = steadyNow();
    while (running_) {
      wake_up.wait();
      const double now = steadyNow();
      tension_.update();
      for (size_t k = 0; k < settings_.winches.size(); ++k)
        hardware.setTension(settings_.winches[k], tension_.front()[static_cast<Eigen::Index>(k)]);
      hardware.step(now - moved_until);
      moved_until = now;
      for (size_t k = 0; k < settings_.winches.size(); ++k)
        reeled_in_.back()[static_cast<Eigen::Index>(k)] = hardware.reeledIn(settings_.winches[k]);
      reeled_in_.publish();
      device_load_.update();
    }
  }

  // The devices have to answer in time whatever the machine does; the body may take what is left.
  void moveBody() {
    const NormalPriority gives_way;
    PeriodicWakeUp wake_up(1 / settings_.plant_rate);
    const int steps_per_display =
        std::max(1, static_cast<int>(std::lround(settings_.plant_rate / settings_.display_rate)));
    for (int step = 0; running_; ++step) {
      wake_up.wait();
      const ros::Time stamp = ros::Time::now();
      const double time = steadyNow();
      reeled_in_.update();
      if (obstacles_) plant_.setObstacles(obstacles_->update(time));
      for (size_t k = 0; k < settings_.winches.size(); ++k)
        plant_.setSnapped(static_cast<int>(k), devices_.hardware().snapped(settings_.winches[k]));
      plant_.step(reeled_in_.front(), wake_up.period());
      tension_.write(plant_.simulator().effort());
      track(stamp, time);
      publishEffectors(stamp);
      publishContacts(stamp);
      devices_.publish(stamp);
      if (step % steps_per_display == 0) publishBody(stamp);
      skipped_steps_ = wake_up.skipped();
      failed_steps_ = plant_.failedSteps();
      residual_ = plant_.simulator().residualRelative();
      step_time_ = steadyNow() - time;
      body_load_.update();
    }
  }

  void track(ros::Time stamp, double time) {
    tracker_.look(time, plant_.simulator().effectors());
    SimulatedTracker::Sample sample;
    while (tracker_.take(time, sample)) {
      geometry_msgs::PoseStamped message;
      message.header.frame_id = effectors_message_.header.frame_id;
      const double age = time - sample.time;
      message.header.stamp = age < stamp.toSec() ? stamp - ros::Duration(age) : ros::Time();  // simulated time may be 0
      for (size_t effector = 0; effector < tracked_.size(); ++effector) {
        message.pose = makePose(sample.effectors, effector);
        tracked_[effector].publish(message);
      }
    }
  }

  void publishEffectors(ros::Time stamp) {
    effectors_message_.header.stamp = stamp;
    for (size_t effector = 0; effector < effectors_message_.pose.size(); ++effector) {
      effectors_message_.pose[effector] = makePose(plant_.simulator().effectors(), effector);
    }
    effectors_.publish(effectors_message_);
  }

  void publishContacts(ros::Time stamp) {
    if (contacts_.getNumSubscribers() == 0) return;
    const ForwardSimulator& simulator = plant_.simulator();
    contacts_message_.header.stamp = stamp;
    contacts_message_.contacts.clear();
    for (int i = 0; i < simulator.contacts().size(); ++i) {
      const ContactRow& row = simulator.contacts().row(i);
      contacts_message_.contacts.push_back(makeContactMessage(row, simulator.contactForce()[i], row.gap, part_owners_));
    }
    contacts_.publish(contacts_message_);
  }

  void publishBody(ros::Time stamp) {
    if (body_.getNumSubscribers() == 0) return;
    const ForwardSimulator& simulator = plant_.simulator();
    const Surface& surface = plant_.robot().surface();
    body_message_.header.stamp = stamp;
    for (size_t vertex = 0; vertex < surface.nodes.size(); ++vertex) {
      body_message_.vertices[vertex] = toPoint32(simulator.nodes()[static_cast<size_t>(surface.nodes[vertex])]);
    }
    body_message_.cable_points.clear();
    for (size_t i = 0; i < body_message_.cable.size(); ++i) {
      const int cable = static_cast<int>(i);
      simulator.calcCablePoints(cable, cable_points_);
      body_message_.cable_size[i] = static_cast<uint32_t>(cable_points_.size());
      body_message_.cable_tension[i] = simulator.effort()[cable];
      for (const Vec3& point : cable_points_) body_message_.cable_points.push_back(toPoint32(point));
    }
    body_.publish(body_message_);
  }

  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
    const double body_share = body_load_.takeShare();
    if (failed_steps_ > 0) {
      status.summary(diagnostic_msgs::DiagnosticStatus::WARN, "steps of the body have failed");
    } else if (body_share > 0.9) {
      status.summary(diagnostic_msgs::DiagnosticStatus::WARN, "the body is too large for its rate");
    } else {
      status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
    }
    status.addf("body rate [Hz]", "%.1f", settings_.plant_rate);
    status.addf("body step [ms]", "%.2f", 1e3 * step_time_);
    status.addf("body share of a core [%]", "%.1f", 1e2 * body_share);
    status.addf("servos share of a core [%]", "%.1f", 1e2 * device_load_.takeShare());
    status.add("body steps failed", failed_steps_.load());
    status.add("body steps skipped", skipped_steps_.load());
    status.addf("body residual [1]", "%.2e", residual_.load());
    const LineFaultCounts line = devices_.faults().lineCounts();
    status.add("line packets sent", line.sent);
    status.add("line packets corrupted", line.corrupted);
    status.add("line packets dropped", line.dropped);
    status.add("line packets delayed", line.delayed);
    for (const auto& [fault, count] : devices_.faults().counts()) status.add("injected " + fault, count);
  }

  const SimulatedRobotSettings settings_;
  SimulatedPlant plant_;  // body thread
  SimulatedDevicesDesk devices_;
  NewestWins<VecX> reeled_in_;  // m, from the devices to the body
  NewestWins<VecX> tension_;    // N, back
  SimulatedTracker tracker_;    // body thread

  ros::NodeHandle node_;
  std::unique_ptr<SimulatedObstacles> obstacles_;  // body thread; null where none is tracked
  diagnostic_updater::Updater diagnostics_;
  std::vector<ros::Publisher> tracked_;
  ros::Publisher effectors_, body_, contacts_;
  ros::WallTimer diagnostics_timer_;
  EffectorTargets effectors_message_;
  BodyState body_message_;
  ContactArray contacts_message_;
  std::vector<std::string> part_owners_;
  std::vector<Vec3> cable_points_;

  std::atomic<bool> running_{true};
  std::atomic<std::uint64_t> skipped_steps_{0}, failed_steps_{0};
  std::atomic<double> residual_{0}, step_time_{0};
  ThreadLoad device_load_, body_load_;
  std::thread device_thread_, body_thread_;
};

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  const std::string not_allowed = sinew::requestRealTime();
  ros::init(argc, argv, "simulated_robot");
  if (!not_allowed.empty()) ROS_WARN("on a busy machine servos may answer late: %s", not_allowed.c_str());
  try {
    const ros::NodeHandle private_node("~");
    sinew::SimulatedRobotNode node(ros::NodeHandle(), private_node, sinew::readSimulatedRobotSettings(private_node));
    sinew::spinUntilShutdown();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
}
