// The tip of the simulated trunk on a horizontal circle: radius 40 mm, 8 s a turn, two turns, the first half turn left
// out. Watches the wire only.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/ActuatorCommand.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
#include <std_msgs/Float64.h>

#include <atomic>
#include <cmath>
#include <map>
#include <vector>

#include "callback_thread.h"
#include "control_loop.h"
#include "quantile.h"
#include "real_time.h"
#include "results.h"
#include "ros_conversions.h"
#include "ros_main.h"

namespace sinew {
namespace {

constexpr double kTurn = 8;       // s
constexpr double kTurns = 2;      // 1
constexpr double kRate = 100;     // Hz
constexpr double kPatience = 90;  // s until the circle has to be done

/// Listens to the line while the targets run through the part of the curve that counts. All callbacks in one thread.
class Listener {
 public:
  Listener() {
    const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
    subscribers_ = {node_.subscribe("targets", 100, &Listener::onTargets, this, hints),
                    node_.subscribe("actuator_command", 100, &Listener::onCommand, this, hints),
                    node_.subscribe("controller_state", 100, &Listener::onState, this, hints),
                    node_.subscribe("plant/effectors", 100, &Listener::onPlant, this, hints),
                    node_.subscribe("trajectory_time", 100, &Listener::onTime, this, hints)};
  }

  bool counts() const { return time_ >= kTurn / 2 && time_ <= kTurns * kTurn; }
  bool done() const { return time_ > kTurns * kTurn; }

  std::vector<double> model_errors;  // m
  std::vector<double> plant_errors;  // m, from the target of the moment
  std::vector<double> periods;       // s
  std::vector<double> cycle_median;  // s
  std::size_t held = 0, degraded = 0;
  std::uint64_t first_misses = 0, last_misses = 0;

  /// s from the receipt of a target to that of the first command that used it or a newer one.
  std::vector<double> calcLatencies() const {
    std::vector<double> latencies;
    for (const auto& target : target_receipts_) {
      const auto use = command_of_target_.lower_bound(target.first);
      if (use == command_of_target_.end()) continue;
      const auto command = command_receipts_.find(use->second);
      if (command != command_receipts_.end()) latencies.push_back(command->second - target.second);
    }
    return latencies;
  }

 private:
  void onTime(const std_msgs::Float64& message) { time_ = message.data; }

  void onTargets(const EffectorTargets& message) {
    target_ = toVec3(message.pose.front().position);
    targeted_ = true;
    if (counts()) target_receipts_[message.header.seq] = steadyNow();
  }

  void onCommand(const ActuatorCommand& message) {
    if (counts()) command_receipts_[message.sequence] = steadyNow();
  }

  void onState(const ControllerState& message) {
    if (!counts()) return;
    if (periods.empty()) first_misses = message.deadline_misses;
    last_misses = message.deadline_misses;
    periods.push_back(message.period);
    model_errors.push_back(message.effectors.front().error);
    cycle_median.push_back(message.stages.back().median);
    if (message.status == ControllerState::HELD) ++held;
    if (message.status == ControllerState::DEGRADED) ++degraded;
    for (const InputStamp& input : message.inputs) {
      const bool is_target = input.topic.size() >= 8 && input.topic.compare(input.topic.size() - 8, 8, "/targets") == 0;
      if (is_target) command_of_target_.emplace(input.sequence, message.sequence);
    }
  }

  void onPlant(const EffectorTargets& message) {
    if (counts() && targeted_) plant_errors.push_back((toVec3(message.pose.front().position) - target_).norm());
  }

  ros::NodeHandle node_;
  std::vector<ros::Subscriber> subscribers_;
  std::atomic<double> time_{-1e9};  // s along the circle
  Vec3 target_;                     // m, of the moment
  bool targeted_ = false;
  std::map<std::uint32_t, double> target_receipts_, command_receipts_;  // s by sequence
  std::map<std::uint32_t, std::uint32_t> command_of_target_;            // sequences
};

TEST(TrunkCircle, IsFollowedInTime) {
  Listener listener;
  ControlLoop control(kRate);
  CallbackThread spinner(*ros::getGlobalCallbackQueue());
  spinner.start();
  const double begin = steadyNow();
  while (!listener.done() && steadyNow() - begin < kPatience) {
    if (listener.counts()) control.start();
    ros::WallDuration(0.02).sleep();
  }
  spinner.stop();
  control.stop();
  const std::vector<double>& control_periods = control.periods();

  ASSERT_TRUE(listener.done()) << "the circle was not finished within " << kPatience << " s";
  ASSERT_GT(listener.periods.size(), 0.9 * kRate * (kTurns - 0.5) * kTurn);
  ASSERT_GT(listener.plant_errors.size(), 100U);
  expectAtMost("trunk_circle.model_error", 1e3 * calcMean(listener.model_errors), 1.0, "mm");
  expectAtMost("trunk_circle.plant_error", 1e3 * calcMean(listener.plant_errors), 1.5, "mm");
  expectAtMost("trunk_circle.held_cycles", static_cast<double>(listener.held), 0, "1");
  expectAtMost("trunk_circle.degraded_cycles", static_cast<double>(listener.degraded), 0, "1");

  const double period_deviation = std::abs(calcMean(listener.periods) - 1 / kRate);
  expectAtMost("trunk_circle.mean_period_deviation", 1e3 * period_deviation, 0.05, "ms");
  ASSERT_GT(control_periods.size(), 100U);
  const double allowed = calcQuantile(control_periods, 0.999) + 0.5e-3;
  expectAtMost("trunk_circle.period_p99.9", 1e3 * calcQuantile(listener.periods, 0.999), 1e3 * allowed, "ms");
  const std::vector<double> latencies = listener.calcLatencies();
  ASSERT_GT(latencies.size(), 100U);
  for (double share : {0.5, 0.95, 0.99, 1.0}) {
    std::printf("latency p%g %.3f ms\n", 1e2 * share, 1e3 * calcQuantile(latencies, share));
  }
  expectAtMost("trunk_circle.latency_p99", 1e3 * calcQuantile(latencies, 0.99), 1e3 / kRate + 2, "ms");
  std::printf("cycle median %.2f ms, missed %lu\n", 1e3 * calcQuantile(listener.cycle_median, 0.5),
              static_cast<unsigned long>(listener.last_misses - listener.first_misses));
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  return sinew::runTestsAsNode(argc, argv, "trunk_circle_test");
}
