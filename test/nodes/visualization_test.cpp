// Plays the controller and the user's mouse to the visualization node.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/BodyState.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
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

class VisualizationTest : public testing::Test {
 protected:
  VisualizationTest() {
    body_ = node_.advertise<BodyState>("body_state", 1);
    controller_ = node_.advertise<ControllerState>("controller_state", 1);
    feedback_ = node_.advertise<InteractiveMarkerFeedback>("target_handles/feedback", 10);
    subscribers_ = {node_.subscribe("markers", 10, &VisualizationTest::onMarkers, this),
                    node_.subscribe("targets", 10, &VisualizationTest::onTargets, this),
                    node_.subscribe("target_handles/update", 100, &VisualizationTest::onUpdate, this),
                    node_.subscribe("target_handles/update_full", 10, &VisualizationTest::onInit, this)};
    state_.header.frame_id = "trunk_base";
    state_.effectors.resize(1);
    state_.effectors[0].name = "tip";
    state_.effectors[0].position = state_.effectors[0].target = toPoint(kTip);
  }

  void onMarkers(const visualization_msgs::MarkerArray& message) {
    for (const auto& marker : message.markers) markers_[marker.ns] = marker;
  }
  void onTargets(const EffectorTargets& message) { targets_.push_back(message); }
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

  bool handleIsAt(const Vec3& position) const {
    const auto found = handles_.find("tip");
    return found != handles_.end() && (found->second - position).norm() < 2e-4;
  }

  void drag(const Vec3& position) {
    InteractiveMarkerFeedback feedback;
    feedback.header.frame_id = "trunk_base";
    feedback.client_id = "test";
    feedback.marker_name = "tip";
    feedback.event_type = InteractiveMarkerFeedback::POSE_UPDATE;
    feedback.pose.position = toPoint(position);
    feedback.pose.orientation.w = 1;
    feedback_.publish(feedback);
  }

  ros::NodeHandle node_;
  ControllerState state_;
  ros::Publisher body_, controller_, feedback_;
  std::vector<ros::Subscriber> subscribers_;
  std::map<std::string, visualization_msgs::Marker> markers_;  // by namespace
  std::map<std::string, Vec3> handles_;                        // by name
  std::vector<EffectorTargets> targets_;
};

TEST_F(VisualizationTest, DrawsAndLetsTheUserDrag) {
  state_.status = ControllerState::DISABLED;
  ASSERT_TRUE(play([this] { return markers_.count("body") > 0 && markers_.count("effectors") > 0; }));
  EXPECT_EQ("trunk_base", markers_["body"].header.frame_id);
  EXPECT_EQ(12u, markers_["body"].points.size());
  EXPECT_EQ(0u, markers_.count("targets"));
  EXPECT_TRUE(handles_.empty()) << "nothing to drag while the controller is disabled";

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
  EXPECT_TRUE(play([this] { return handles_.empty(); }));
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "visualization_test");
  const ros::NodeHandle node;
  return RUN_ALL_TESTS();
}
