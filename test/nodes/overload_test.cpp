// Overload of a running node. Far above the rate that is possible, every command still goes out; the level rises with
// the load and falls when it has gone.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/ActuatorCommand.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
#include <sinew/TrackedObstacles.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>

#include "callback_thread.h"
#include "control_loop.h"
#include "inverse_model_node.h"
#include "results.h"
#include "ros_main.h"

namespace sinew {
namespace {

constexpr double kHighestRate = 2000, kLeisurelyRate = 5;  // Hz
constexpr double kPatience = 60, kRun = 10;                // s
constexpr int kTop = static_cast<int>(kHighestOverload);

/// Publishes targets and what it touches, and listens. Heavy, what it touches is there.
class Bench {
 public:
  explicit Bench(double rate) {
    ros::NodeHandle parameters("~");
    parameters.setParam("rate", rate);
    targets_ = node_.advertise<EffectorTargets>("targets", 1);
    obstacles_ = node_.advertise<TrackedObstacles>("tracked_obstacles", 1);
    const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
    commands_ = node_.subscribe("actuator_command", 20000, &Bench::onCommand, this, hints);
    states_ = node_.subscribe("controller_state", 20000, &Bench::onState, this, hints);
    target_.header.frame_id = obstacle_.header.frame_id = "trunk_base";
    target_.name = {"tip"};
    target_.pose.resize(1);
    target_.pose[0].orientation.w = 1;
    target_.pose[0].position.z = 0.19;
    obstacle_.name = {"cylinder"};
    obstacle_.pose.resize(1);
    obstacle_.pose[0].orientation.x = obstacle_.pose[0].orientation.w = std::sqrt(0.5);
    obstacle_.pose[0].position.x = 0.037;
    obstacle_.pose[0].position.z = 0.11;
    obstacle_.present = {false};
    callbacks_ = std::make_unique<CallbackThread>(*ros::getGlobalCallbackQueue());
    callbacks_->start();
    const NormalPriority while_building;
    controller_ = std::make_unique<InverseModelNode>(ros::NodeHandle(), parameters);
  }

  ~Bench() {
    controller_.reset();
    callbacks_->stop();
  }

  void setHeavy(bool heavy) { obstacle_.present = {heavy}; }

  /// False when `reached` does not come true in time.
  bool run(
      double seconds, const std::function<bool()>& reached = [] { return false; }) {
    for (const double begin = steadyNow(); steadyNow() - begin < seconds; ros::WallDuration(0.02).sleep()) {
      target_.pose[0].position.x = 0.005 * std::sin(steadyNow());
      targets_.publish(target_);
      obstacles_.publish(obstacle_);
      if (reached()) return true;
    }
    return false;
  }

  std::atomic<bool> counts{false};
  std::atomic<int> level{-1};
  std::atomic<double> taken{0};  // s, median of a cycle
  std::atomic<bool> enabled{false};
  std::atomic<long> commands{0}, lost_commands{0}, held{0}, misses{0}, undegraded{0};

 private:
  void onCommand(const ActuatorCommand& command) {
    enabled = true;
    if (counts && sequence_ != 0) lost_commands += command.sequence - sequence_ - 1;
    if (counts) ++commands;
    sequence_ = command.sequence;
  }

  void onState(const ControllerState& state) {
    level = state.overload_level;
    taken = state.stages.back().median;
    misses = static_cast<long>(state.deadline_misses);
    if (!counts) return;
    held += state.status == ControllerState::HELD;
    undegraded += state.overload_level > 0 && (state.status != ControllerState::DEGRADED || state.reason.empty());
  }

  ros::NodeHandle node_;
  ros::Publisher targets_, obstacles_;
  ros::Subscriber commands_, states_;
  EffectorTargets target_;
  TrackedObstacles obstacle_;
  std::uint32_t sequence_ = 0;
  std::unique_ptr<CallbackThread> callbacks_;
  std::unique_ptr<InverseModelNode> controller_;
};

TEST(Overload, everyCommandGoesOutFarAboveTheRateThatIsPossible) {
  Bench bench(kHighestRate);
  ASSERT_TRUE(bench.run(kPatience, [&bench] { return bench.enabled.load(); }));
  bench.run(1);
  ControlLoop control(kHighestRate);
  const long misses_before = bench.misses;
  control.start();
  bench.counts = true;
  const double begin = steadyNow();
  bench.run(kRun);
  bench.counts = false;
  const double seconds = steadyNow() - begin;
  control.stop();
  std::printf("cycle median %.3f ms, missed %ld, control loop with it %zu, alone %zu\n", 1e3 * bench.taken,
              bench.misses - misses_before, control.countMisses(bench.taken), control.countMisses(0));
  EXPECT_EQ(bench.level, kTop);
  expectAtMost("overload.lost_commands", static_cast<double>(bench.lost_commands), 0, "1");
  expectAtMost("overload.undegraded", static_cast<double>(bench.undegraded), 0, "1");
  const double allowed = static_cast<double>(control.countMisses(bench.taken));
  expectAtMost("overload.missing_commands", seconds * kHighestRate - static_cast<double>(bench.commands),
               allowed + 0.05 * kHighestRate, "1");  // 50 ms for both ends
}

/// s that a cycle takes at leisure with or without contacts.
double measureCycle(bool heavy) {
  Bench bench(kLeisurelyRate);
  bench.setHeavy(heavy);
  EXPECT_TRUE(bench.run(kPatience, [&bench] { return bench.enabled && bench.level == 0; }));
  bench.run(4);
  return bench.taken;
}

TEST(Overload, theLevelRisesWithTheLoadAndFallsWithIt) {
  const double light = measureCycle(false), heavy = measureCycle(true);
  // At leisure a cycle finds its data outside the caches, and takes longer than one of many in a row.
  const double rate = std::min(2 * kHighestRate, 1.6 / heavy);
  std::printf("a cycle takes %.3f ms without contacts, %.3f ms with: %.0f Hz\n", 1e3 * light, 1e3 * heavy, rate);
  ASSERT_GT(heavy, 1.8 * light) << "the load is none";
  Bench bench(rate);
  EXPECT_TRUE(bench.run(kPatience, [&bench] { return bench.enabled && bench.level == 0; })) << "it does not come down";
  bench.counts = true;
  bench.setHeavy(true);
  EXPECT_TRUE(bench.run(kPatience, [&bench] { return bench.level > 0; })) << "it does not rise";
  bench.run(2);
  bench.setHeavy(false);
  EXPECT_TRUE(bench.run(kPatience, [&bench] { return bench.level == 0; })) << "it does not come down again";
  bench.counts = false;
  expectAtMost("overload.rise_and_fall.lost_commands", static_cast<double>(bench.lost_commands), 0, "1");
  expectAtMost("overload.rise_and_fall.undegraded", static_cast<double>(bench.undegraded), 0, "1");
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  return sinew::runTestsAsNode(argc, argv, "inverse_model");
}
