// Moves an obstacle of the simulated world along a line: tells the simulated robot where it is, and the controller what
// a tracking system would see of it.

#include <ros/ros.h>
#include <sinew/ControllerState.h>
#include <sinew/TrackedObstacles.h>

#include <atomic>
#include <exception>
#include <string>
#include <thread>

#include "callback_thread.h"
#include "moving_obstacle_node_stroke.h"
#include "parameters.h"
#include "real_time.h"
#include "ros_conversions.h"
#include "simulated_robot_node_tracker.h"
#include "sinew/robot/robot_description.h"

namespace sinew {
namespace {

constexpr double kTruthPeriod = 0.005;  // s

struct Settings {
  std::string frame, obstacle;
  Pose start_pose;  // m, in the robot's frame
  Vec3 direction;   // unit
  ObstacleStroke stroke;
  double start;  // s after the controller was first enabled
  SimulatedTracker::Parameters tracker;
};

const ObstacleDescription& findObstacle(const RobotDescription& robot, const Parameters& parameters) {
  const std::string name = parameters.text("obstacle");
  for (const ObstacleDescription& obstacle : robot.obstacles) {
    if (obstacle.name == name && obstacle.tracked) return obstacle;
  }
  parameters.fail("obstacle", name, "an obstacle of the robot with tracked: true");
}

Settings readSettings(const Parameters& parameters) {
  const RobotDescription robot = readRobotDescription(parameters.text("robot"));
  const ObstacleDescription& obstacle = findObstacle(robot, parameters);
  Settings settings;
  settings.frame = robot.frame;
  settings.obstacle = obstacle.name;
  settings.start_pose = obstacle.pose;
  settings.start_pose.translation() += parameters.vec3Or("offset", Vec3::Zero());
  settings.direction = parameters.vec3Or("direction", Vec3::UnitX());
  if (!(settings.direction.norm() > 0)) parameters.fail("direction", "zero", "a direction in the robot's frame");
  settings.direction.normalize();
  ObstacleStroke& stroke = settings.stroke;
  stroke.amplitude = parameters.numberOr("amplitude", stroke.amplitude, 0, 10);
  stroke.speed = parameters.numberOr("speed", stroke.speed, 1e-6, 10);
  stroke.dwell = parameters.numberOr("dwell", stroke.dwell, 0, 1e6);
  stroke.turns = parameters.integerOr("turns", stroke.turns, 0, 1000000);
  settings.start = parameters.numberOr("start", 2, 0, 1e6);
  SimulatedTracker::Parameters& tracker = settings.tracker;
  tracker.rate = parameters.numberOr("rate", 60, 0.1, 2000);
  tracker.latency = parameters.numberOr("latency", 0.03, 0, 10);
  tracker.noise = parameters.numberOr("noise", 0.0003, 0, 1);
  tracker.seed = static_cast<std::uint32_t>(parameters.integerOr("seed", 1, 0, 1 << 30));
  return settings;
}

class MovingObstacleNode {
 public:
  MovingObstacleNode(ros::NodeHandle node, const Settings& settings)
      : settings_(settings),
        tracker_(settings.tracker),
        truth_(node.advertise<TrackedObstacles>("true_obstacles", 10)),
        tracked_(node.advertise<TrackedObstacles>("tracked_obstacles", 10)),
        state_(node.subscribe("controller_state", 1, &MovingObstacleNode::onState, this)) {
    message_.header.frame_id = settings.frame;
    message_.name.push_back(settings.obstacle);
    message_.pose.push_back(toPoseMessage(settings.start_pose));
    message_.present.push_back(true);
    thread_ = std::thread([this] { run(); });
  }

  ~MovingObstacleNode() {
    running_ = false;
    thread_.join();
  }

 private:
  void onState(const ControllerState& state) {
    if (begin_ >= 0 || state.status == ControllerState::DISABLED) return;
    begin_ = steadyNow() + settings_.start;
    ROS_INFO_STREAM("'" << settings_.obstacle << "' starts in " << settings_.start << " s");
  }

  void run() {
    PeriodicWakeUp wake_up(kTruthPeriod);
    while (running_) {
      wake_up.wait();
      move(steadyNow(), ros::Time::now());
    }
  }

  void move(double now, const ros::Time& stamp) {
    const double distance = begin_ < 0 ? 0 : settings_.stroke.calcDistance(now - begin_);
    const Vec3 position = settings_.start_pose.translation() + distance * settings_.direction;
    publish(position, stamp, truth_);
    tracker_.look(now, position);
    SimulatedTracker::Sample sample;
    while (tracker_.take(now, sample)) {
      const double age = now - sample.time;
      const bool dated = age < stamp.toSec();  // simulated time may be 0
      publish(sample.effectors, dated ? stamp - ros::Duration(age) : ros::Time(), tracked_);
    }
  }

  void publish(const Vec3& position, const ros::Time& stamp, ros::Publisher& publisher) {
    message_.header.stamp = stamp;
    message_.pose.front().position = toPoint(position);
    publisher.publish(message_);
  }

  const Settings settings_;
  SimulatedTracker tracker_;
  TrackedObstacles message_;
  ros::Publisher truth_, tracked_;
  ros::Subscriber state_;
  std::atomic<double> begin_{-1};  // s, steady, of the first stroke; negative before the controller was enabled
  std::atomic<bool> running_{true};
  std::thread thread_;
};

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  const std::string not_allowed = sinew::requestRealTime();
  ros::init(argc, argv, "moving_obstacle");
  if (!not_allowed.empty()) ROS_WARN("on a busy machine samples may be late: %s", not_allowed.c_str());
  try {
    const sinew::Settings settings = sinew::readSettings(sinew::Parameters(ros::NodeHandle("~")));
    sinew::MovingObstacleNode node(ros::NodeHandle(), settings);
    sinew::spinUntilShutdown();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
