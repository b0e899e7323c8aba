// Publishes frames of tf as tracked obstacles, for tracking systems that speak tf only.

#include <ros/ros.h>
#include <sinew/TrackedObstacles.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/transform_listener.h>

#include <exception>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "parameters.h"
#include "ros_conversions.h"

namespace sinew {
namespace {

struct Settings {
  double rate;                                // Hz
  std::string reference;                      // frame in which the obstacles are reported
  std::map<std::string, std::string> frames;  // by obstacle
};

Settings readSettings(const ros::NodeHandle& private_node) {
  const Parameters parameters(private_node);
  Settings settings;
  settings.rate = parameters.numberOr("rate", 60, 0.1, 1000);
  settings.reference = parameters.text("reference");
  if (!private_node.getParam("frames", settings.frames) || settings.frames.empty()) {
    parameters.fail("frames", "nothing, or something else than names of frames", "{OBSTACLE: FRAME, ...}");
  }
  return settings;
}

class ObstacleTfNode {
 public:
  ObstacleTfNode(ros::NodeHandle node, const Settings& settings)
      : settings_(settings),
        listener_(transforms_),
        publisher_(node.advertise<TrackedObstacles>("tracked_obstacles", 10)),
        timer_(node.createSteadyTimer(ros::WallDuration(1 / settings.rate), &ObstacleTfNode::onTimer, this)) {}

 private:
  // A frame that has not moved on since is not reported again, so that the listener sees it grow old.
  void onTimer(const ros::SteadyTimerEvent&) {
    for (const auto& [obstacle, frame] : settings_.frames) {
      try {
        report(obstacle, transforms_.lookupTransform(settings_.reference, frame, ros::Time(0)));
      } catch (const tf2::TransformException& error) {
        ROS_WARN_STREAM_THROTTLE(5.0, "obstacle '" << obstacle << "' is not reported: " << error.what());
      }
    }
  }

  void report(const std::string& obstacle, const geometry_msgs::TransformStamped& transform) {
    ros::Time& last = last_[obstacle];
    const bool fixed = transform.header.stamp.isZero();
    if (!fixed && transform.header.stamp == last) return;
    last = transform.header.stamp;
    TrackedObstacles message;
    message.header.frame_id = settings_.reference;
    message.header.stamp = fixed ? ros::Time::now() : last;
    message.name.push_back(obstacle);
    message.pose.push_back(toPoseMessage(tf2::transformToEigen(transform)));
    message.present.push_back(true);
    publisher_.publish(message);
  }

  const Settings settings_;
  tf2_ros::Buffer transforms_;
  tf2_ros::TransformListener listener_;
  std::map<std::string, ros::Time> last_;  // stamps, by obstacle
  ros::Publisher publisher_;
  ros::SteadyTimer timer_;
};

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  ros::init(argc, argv, "obstacle_tf");
  try {
    sinew::ObstacleTfNode node(ros::NodeHandle(), sinew::readSettings(ros::NodeHandle("~")));
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
