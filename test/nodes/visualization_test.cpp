// Plays the controller and the user's mouse to the visualization node.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/BodyState.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
#include <sinew/TrackedObstacles.h>
#include <visualization_msgs/InteractiveMarkerFeedback.h>
#include <visualization_msgs/InteractiveMarkerInit.h>
#include <visualization_msgs/InteractiveMarkerUpdate.h>
#include <visualization_msgs/MarkerArray.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "ros_conversions.h"

namespace sinew {
namespace {

using visualization_msgs::InteractiveMarkerFeedback;

constexpr double kPatience = 20;   // s, for a machine that is busy with other things
const Vec3 kTip(0.01, 0.02, 0.2);  // m
const Vec3 kTarget(0.03, 0.02, 0.19);
const Vec3 kPost(0.1, 0, 0.1);

class VisualizationTest : public testing::Test {
 protected:
  VisualizationTest() {
    body_ = node_.advertise<BodyState>("body_state", 1);
    controller_ = node_.advertise<ControllerState>("controller_state", 1);
    feedback_ = node_.advertise<InteractiveMarkerFeedback>("target_handles/feedback", 10);
    obstacle_feedback_ = node_.advertise<InteractiveMarkerFeedback>("obstacle_handles/feedback", 10);
    believed_ = node_.advertise<TrackedObstacles>("obstacles", 1);
    tracked_publisher_ = node_.advertise<TrackedObstacles>("tracked_obstacles", 1);
    subscribers_ = {node_.subscribe("markers", 10, &VisualizationTest::onMarkers, this),
                    node_.subscribe("targets", 10, &VisualizationTest::onTargets, this),
                    node_.subscribe("tracked_obstacles", 100, &VisualizationTest::onTracked, this),
                    node_.subscribe("target_handles/update", 100, &VisualizationTest::onUpdate, this),
                    node_.subscribe("target_handles/update_full", 10, &VisualizationTest::onInit, this),
                    node_.subscribe("obstacle_handles/update", 100, &VisualizationTest::onUpdate, this),
                    node_.subscribe("obstacle_handles/update_full", 10, &VisualizationTest::onInit, this)};
    obstacles_.header.frame_id = "trunk_base";
    obstacles_.name = {"post", "table"};
    obstacles_.pose.resize(2);
    obstacles_.pose[0] = obstacles_.pose[1] = toPoseMessage(Pose::Identity());
    obstacles_.pose[0].position = toPoint(kPost);
    obstacles_.present = {true, true};
    state_.header.frame_id = "trunk_base";
    state_.effectors.resize(1);
    state_.effectors[0].name = "tip";
    state_.effectors[0].position = state_.effectors[0].target = toPoint(kTip);
  }

  void onMarkers(const visualization_msgs::MarkerArray& message) {
    for (const auto& marker : message.markers) markers_[marker.ns] = marker;
  }
  void onTargets(const EffectorTargets& message) { targets_.push_back(message); }
  void onTracked(const TrackedObstacles& message) { tracked_.push_back(message); }
  void onInit(const visualization_msgs::InteractiveMarkerInit& message) {
    for (const auto& marker : message.markers) handles_[marker.name] = toVec3(marker.pose.position);
  }
  void onUpdate(const visualization_msgs::InteractiveMarkerUpdate& message) {
    for (const std::string& name : message.erases) handles_.erase(name);
    for (const auto& marker : message.markers) handles_[marker.name] = toVec3(marker.pose.position);
    for (const auto& pose : message.poses) handles_[pose.name] = toVec3(pose.pose.position);
  }

  BodyState makeBody() const {
    BodyState body;
    body.header.frame_id = "trunk_base";
    for (const Vec3& vertex : {Vec3(0, 0, 0), Vec3(0.02, 0, 0), Vec3(0, 0.02, 0), Vec3(0, 0, 0.2)}) {
      body.vertices.push_back(toPoint32(vertex));
    }
    body.triangles = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
    return body;
  }

  /// Publishes body and controller until `done`.
  bool play(const std::function<bool()>& done) {
    const ros::SteadyTime start = ros::SteadyTime::now();
    while ((ros::SteadyTime::now() - start).toSec() < kPatience) {
      state_.header.stamp = ros::Time::now();
      body_.publish(makeBody());
      controller_.publish(state_);
      obstacles_.header.stamp = state_.header.stamp;
      believed_.publish(obstacles_);
      ros::WallDuration(0.02).sleep();
      ros::spinOnce();
      if (done()) return true;
    }
    return false;
  }

  void playFor(double seconds) {
    const ros::SteadyTime start = ros::SteadyTime::now();
    play([&] { return (ros::SteadyTime::now() - start).toSec() > seconds; });
  }

  bool handleIsAt(const Vec3& position, const std::string& name = "tip") const {
    const auto found = handles_.find(name);
    return found != handles_.end() && (found->second - position).norm() < 2e-4;
  }

  void drag(const Vec3& position, const std::string& name = "tip") {
    InteractiveMarkerFeedback feedback;
    feedback.header.frame_id = "trunk_base";
    feedback.client_id = "test";
    feedback.marker_name = name;
    feedback.event_type = InteractiveMarkerFeedback::POSE_UPDATE;
    feedback.pose.position = toPoint(position);
    feedback.pose.orientation.w = 1;
    (name == "tip" ? feedback_ : obstacle_feedback_).publish(feedback);
  }

  ros::NodeHandle node_;
  ControllerState state_;
  TrackedObstacles obstacles_;
  ros::Publisher body_, controller_, feedback_, obstacle_feedback_, believed_, tracked_publisher_;
  std::vector<ros::Subscriber> subscribers_;
  std::map<std::string, visualization_msgs::Marker> markers_;  // by namespace
  std::map<std::string, Vec3> handles_;                        // by name
  std::vector<EffectorTargets> targets_;
  std::vector<TrackedObstacles> tracked_;
};

TEST_F(VisualizationTest, DrawsAndLetsTheUserDrag) {
  state_.status = ControllerState::DISABLED;
  ASSERT_TRUE(play([this] { return markers_.count("body") > 0 && markers_.count("effectors") > 0; }));
  EXPECT_EQ("trunk_base", markers_["body"].header.frame_id);
  EXPECT_EQ(12u, markers_["body"].points.size());
  EXPECT_EQ(0u, markers_.count("targets"));
  EXPECT_EQ(0u, handles_.count("tip")) << "nothing to drag while the controller is disabled";

  state_.status = ControllerState::TRACKING;
  ASSERT_TRUE(play([this] { return handleIsAt(kTip); })) << "a handle starts at the actual position";
  playFor(1.5);
  EXPECT_TRUE(targets_.empty()) << "nobody has dragged";

  state_.effectors[0].targeted = true;
  state_.effectors[0].target = toPoint(kTarget);
  ASSERT_TRUE(play([this] { return handleIsAt(kTarget); })) << "follows the targets of others";
  EXPECT_TRUE(targets_.empty());

  const Vec3 wanted(0, 0, 0.21);
  drag(wanted);
  ASSERT_TRUE(play([this] { return !targets_.empty(); }));
  EXPECT_EQ("trunk_base", targets_.front().header.frame_id);
  ASSERT_EQ(1u, targets_.front().name.size());
  EXPECT_EQ("tip", targets_.front().name[0]);
  EXPECT_LT((toVec3(targets_.front().pose[0].position) - wanted).norm(), 1e-9);

  targets_.clear();
  drag(Vec3(0, 0, 9));
  ASSERT_TRUE(play([this] { return !targets_.empty(); }));
  EXPECT_LT(targets_.front().pose[0].position.z, 0.5) << "clamped to the workspace";

  state_.status = ControllerState::DISABLED;
  EXPECT_TRUE(play([this] { return handles_.count("tip") == 0; }));
}

TEST_F(VisualizationTest, LetsTheUserPushObstacles) {
  ASSERT_TRUE(play([this] { return handleIsAt(kPost, "post") && markers_.count("obstacles") > 0; }));
  EXPECT_EQ(0u, handles_.count("table")) << "what is not tracked stays where it is";
  playFor(1);
  EXPECT_TRUE(tracked_.empty()) << "nobody has dragged";

  const Vec3 wanted = kPost - Vec3(0.04, 0, 0);
  drag(wanted, "post");
  const auto reported = [this] { return toVec3(tracked_.back().pose[0].position); };
  ASSERT_TRUE(play([&] { return !tracked_.empty() && (reported() - wanted).norm() < 1e-9; }));
  EXPECT_EQ("trunk_base", tracked_.front().header.frame_id);
  EXPECT_EQ(std::vector<std::string>{"post"}, tracked_.front().name);
  EXPECT_TRUE(tracked_.front().present[0]);
  Vec3 before = kPost;
  for (const TrackedObstacles& message : tracked_) {
    EXPECT_LT((toVec3(message.pose[0].position) - before).norm(), 0.1 / 20 + 1e-6) << "faster than obstacle_speed";
    before = toVec3(message.pose[0].position);
  }

  playFor(0.5);
  EXPECT_EQ(wanted, reported()) << "goes on to say where it is";
  tracked_publisher_.publish(obstacles_);
  playFor(0.5);
  tracked_.clear();
  playFor(0.5);
  EXPECT_TRUE(tracked_.empty()) << "somebody else reports it now";
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "visualization_test");
  const ros::NodeHandle node;
  return RUN_ALL_TESTS();
}
