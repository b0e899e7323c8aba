// Commands of a running robot go out every period, while an obstacle comes and goes: as many as a loop that only sleeps
// would have made, at the same rate, priority and time. Watches the wire, and what the kernel says of the cycle thread.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/ActuatorCommand.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "callback_thread.h"
#include "control_loop.h"
#include "node_process.h"
#include "quantile.h"
#include "results.h"
#include "ros_main.h"
#include "sinew/inverse/cycle.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr double kPatience = 60;             // s until the robot is controlled
constexpr double kWarmUp = 5;                // s of targets before anything counts
constexpr double kUsual = 60, kFull = 600;   // s that count
constexpr double kFaultsPerSecond = 0.2;     // minor ones: "near none"
constexpr double kHeldShare = 1e-3;          // of the cycles: searches that found nothing in their time
constexpr std::size_t kLevels = static_cast<std::size_t>(kHighestOverload) + 1;

double duration() {
  return std::getenv("SINEW_FULL") != nullptr ? kFull : kUsual;
}

std::string tag(double rate) {
  return "deadlines." + std::to_string(static_cast<int>(rate)) + "hz.";
}

/// Leads the tip on a circle, held nearer to the base than it hangs, and listens.
class Line {
 public:
  Line() : targets_(node_.advertise<EffectorTargets>("targets", 1)) {
    const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
    subscribers_ = {node_.subscribe("actuator_command", 20000, &Line::onCommand, this, hints),
                    node_.subscribe("controller_state", 20000, &Line::onState, this, hints)};
    const auto room = static_cast<std::size_t>(2100 * (duration() + 10));
    for (auto* samples : {&periods, &cycles}) samples->reserve(room);
    target_.header.frame_id = "trunk_base";
    target_.name = {"tip"};
    target_.pose.resize(1);
    target_.pose[0].orientation.w = 1;
  }

  void lead(double seconds) {
    const double begin = steadyNow();
    while (steadyNow() - begin < seconds) {
      const double angle = kTurn * steadyNow() / 5;
      target_.pose[0].position.x = rest_.x + 0.01 * std::cos(angle);
      target_.pose[0].position.y = rest_.y + 0.01 * std::sin(angle);
      target_.pose[0].position.z = rest_.z - 0.02;
      targets_.publish(target_);
      ros::WallDuration(0.02).sleep();
    }
  }

  bool waitUntilEnabled() const {
    for (const double begin = steadyNow(); steadyNow() - begin < kPatience; ros::WallDuration(0.05).sleep()) {
      if (enabled_) return true;
    }
    return false;
  }

  void count(bool counts) { counts_ = counts; }

  std::uint64_t commands = 0, lost_commands = 0, states = 0, sessions = 0;
  std::uint64_t first_misses = 0, last_misses = 0, held = 0, in_contact = 0, oldest = 0;
  std::array<std::uint64_t, kLevels> levels{};
  std::vector<double> periods, cycles;  // s

 private:
  void onCommand(const ActuatorCommand& command) {
    if (!counts_) {
      sequence_ = 0;
      return;
    }
    if (sequence_ != 0 && session_ == command.session) lost_commands += command.sequence - sequence_ - 1;
    sessions += sequence_ == 0 || session_ != command.session;
    session_ = command.session;
    sequence_ = command.sequence;
    ++commands;
  }

  void onState(const ControllerState& state) {
    if (!enabled_ && state.status != ControllerState::DISABLED) {
      rest_ = state.effectors.front().position;
      enabled_ = true;
    }
    if (!counts_) return;
    if (states++ == 0) first_misses = state.deadline_misses;
    last_misses = state.deadline_misses;
    held += state.status == ControllerState::HELD;
    in_contact += state.contacts > 0;
    oldest = std::max<std::uint64_t>(oldest, state.linearisation_age);
    ++levels[state.overload_level];
    periods.push_back(state.period);
    cycles.push_back(state.stages.back().last);
  }

  ros::NodeHandle node_;
  ros::Publisher targets_;
  EffectorTargets target_;
  std::vector<ros::Subscriber> subscribers_;
  geometry_msgs::Point rest_;  // m
  std::atomic<bool> enabled_{false}, counts_{false};
  std::uint32_t sequence_ = 0, session_ = 0;
};

void printJitter(const char* who, const std::vector<double>& periods, double rate) {
  std::vector<double> deviations;
  for (const double period : periods) deviations.push_back(std::abs(period - 1 / rate));
  std::printf("%s: period off by p50 %.3f, p99 %.3f, p99.9 %.3f, at most %.3f ms\n", who,
              1e3 * calcQuantile(deviations, 0.5), 1e3 * calcQuantile(deviations, 0.99),
              1e3 * calcQuantile(deviations, 0.999), 1e3 * calcQuantile(deviations, 1));
}

void expectDeadlinesKept(const Line& line, const ControlLoop& control, double rate) {
  const double work = calcQuantile(line.cycles, 0.99);  // the loop is given as long once it is awake
  const auto allowed = static_cast<double>(control.countMisses(work));
  std::printf(
      "cycle p50 %.3f, p99 %.3f, at most %.3f ms; at levels 0 to 3: %lu %lu %lu %lu cycles; oldest %lu cycles\n",
      1e3 * calcQuantile(line.cycles, 0.5), 1e3 * work, 1e3 * calcQuantile(line.cycles, 1), line.levels[0],
      line.levels[1], line.levels[2], line.levels[3], line.oldest);
  printJitter("controller", line.periods, rate);
  printJitter("control loop", control.periods(), rate);
  expectAtMost(tag(rate) + "misses", static_cast<double>(line.last_misses - line.first_misses), allowed, "1");
}

void expectEveryCommand(const Line& line, double rate, double seconds, double skipped) {
  EXPECT_EQ(line.sessions, 1U);
  expectAtMost(tag(rate) + "lost_commands", static_cast<double>(line.lost_commands), skipped, "1");
  expectAtMost(tag(rate) + "held", static_cast<double>(line.held), kHeldShare * static_cast<double>(line.states), "1");
  const double missing = seconds * rate - static_cast<double>(line.commands);
  expectAtMost(tag(rate) + "missing_commands", missing, skipped + 0.1 * rate, "1");  // 0.1 s for both ends
}

void expectNoFaults(const ThreadUse& before, const ThreadUse& after, double rate, double seconds) {
  ASSERT_GE(before.minor_faults, 0) << "no thread by the name of cycle";
  expectAtMost(tag(rate) + "major_faults", static_cast<double>(after.major_faults - before.major_faults), 0, "1");
  expectAtMost(tag(rate) + "minor_faults", static_cast<double>(after.minor_faults - before.minor_faults),
               kFaultsPerSecond * seconds, "1");
}

TEST(Deadlines, areKept) {
  const double rate = ros::NodeHandle("~").param("rate", 100.0), seconds = duration();
  Line line;
  CallbackThread callbacks(*ros::getGlobalCallbackQueue());
  callbacks.start();
  ASSERT_TRUE(line.waitUntilEnabled());
  line.lead(kWarmUp);
  const pid_t controller = findProcess(ros::names::resolve("inverse_model"));
  ControlLoop control(rate);
  const ThreadUse before = readThreadUse(controller, "cycle");
  control.start();
  line.count(true);
  line.lead(seconds);
  line.count(false);
  control.stop();
  const ThreadUse after = readThreadUse(controller, "cycle");
  callbacks.stop();

  ASSERT_GT(line.states, 0U);
  expectDeadlinesKept(line, control, rate);
  expectEveryCommand(line, rate, seconds, static_cast<double>(control.countMisses(0)));
  expectNoFaults(before, after, rate, seconds);
  EXPECT_GT(line.in_contact, line.states / 10);
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  return sinew::runTestsAsNode(argc, argv, "deadlines_test");
}
