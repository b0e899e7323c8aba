// The cycle thread of a running node takes no memory and no lock: not while an obstacle comes and goes, not at any
// level of overload.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
#include <sinew/TrackedObstacles.h>

#include <cmath>
#include <memory>
#include <thread>

#include "callback_thread.h"
#include "inverse_model_node.h"
#include "results.h"
#include "ros_main.h"
#include "thread_watch.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr double kPatience = 30;             // s
constexpr double kWarmUp = 2, kWatched = 6;  // s

/// Leads the tip to and fro and an obstacle to it and away, and listens to what the controller says.
class Surroundings {
 public:
  Surroundings()
      : targets_(node_.advertise<EffectorTargets>("targets", 1)),
        obstacles_(node_.advertise<TrackedObstacles>("tracked_obstacles", 1)),
        states_(node_.subscribe("controller_state", 1000, &Surroundings::onState, this)) {
    target_.name = {"tip"};
    target_.pose.resize(1);
    target_.pose[0].orientation.w = 1;
    target_.header.frame_id = obstacle_.header.frame_id = "trunk_base";
    obstacle_.name = {"cylinder"};
    obstacle_.present = {true};
    obstacle_.pose.resize(1);
    obstacle_.pose[0].orientation.x = obstacle_.pose[0].orientation.w = std::sqrt(0.5);
    obstacle_.pose[0].position.z = 0.11;
  }

  void move(double seconds) {
    for (const double begin = steadyNow(); steadyNow() - begin < seconds; ros::WallDuration(0.01).sleep()) {
      const double time = steadyNow();
      target_.pose[0].position.x = 0.01 * std::sin(kTurn * time / 2);
      target_.pose[0].position.z = 0.18;
      obstacle_.pose[0].position.x = 0.04 + 0.02 * std::cos(kTurn * time / 3);
      targets_.publish(target_);
      obstacles_.publish(obstacle_);
    }
  }

  bool waitUntilEnabled() {
    for (const double begin = steadyNow(); steadyNow() - begin < kPatience; move(0.1)) {
      if (cycles_enabled > 0) return true;
    }
    return false;
  }

  std::atomic<long> cycles_enabled{0}, cycles_in_contact{0}, cycles_held{0};
  std::atomic<int> levels_seen{0};  // a bit each
  std::string reason_held;          // callback thread

 private:
  void onState(const ControllerState& state) {
    cycles_enabled += state.status != ControllerState::DISABLED;
    cycles_in_contact += state.contacts > 0;
    if (state.status == ControllerState::HELD && cycles_held++ == 0) reason_held = state.reason;
    levels_seen.fetch_or(1 << state.overload_level);
  }

  ros::NodeHandle node_;
  ros::Publisher targets_, obstacles_;
  EffectorTargets target_;
  TrackedObstacles obstacle_;
  ros::Subscriber states_;
};

void expectQuiet(const std::string& name, double rate, int expected_level) {
  if (!watchesThreads()) GTEST_SKIP() << "nothing counts in this build";
  CallbackThread callbacks(*ros::getGlobalCallbackQueue());
  callbacks.start();
  ros::NodeHandle("~").setParam("rate", rate);
  InverseModelNode node((ros::NodeHandle()), ros::NodeHandle("~"));
  Surroundings surroundings;
  ASSERT_TRUE(surroundings.waitUntilEnabled());
  surroundings.move(kWarmUp);
  const ThreadCounts before = countsOf("cycle");
  const long contacts_before = surroundings.cycles_in_contact;
  surroundings.levels_seen = 0;
  surroundings.move(kWatched);
  const ThreadCounts after = countsOf("cycle");
  expectAtMost("control_cycle." + name + ".allocations", static_cast<double>(after.allocations - before.allocations), 0,
               "1");
  expectAtMost("control_cycle." + name + ".locks", static_cast<double>(after.locks - before.locks), 0, "1");
  callbacks.stop();
  EXPECT_GT(surroundings.cycles_in_contact, contacts_before);
  EXPECT_EQ(surroundings.cycles_held, 0) << surroundings.reason_held;
  EXPECT_NE(surroundings.levels_seen & (1 << expected_level), 0) << surroundings.levels_seen;
}

TEST(ControlCycle, watchingWorks) {
  if (!watchesThreads()) GTEST_SKIP() << "nothing counts in this build";
  ThreadCounts counts;
  std::thread thread([&] {
    nameThread("watched");
    for (int k = 0; k < 100; ++k) std::make_unique<std::string>(100, 'x');
    counts = countsOf("watched");
  });
  thread.join();
  EXPECT_GE(counts.allocations, 200);
  EXPECT_EQ(countsOf("nobody").allocations, 0);
}

TEST(ControlCycle, asksNobodyForAnything) {
  expectQuiet("leisurely", 20, 0);
}

TEST(ControlCycle, norInOverload) {
  expectQuiet("overloaded", 2000, 3);
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  return sinew::runTestsAsNode(argc, argv, "inverse_model");
}
