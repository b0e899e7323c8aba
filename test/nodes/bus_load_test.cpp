// A driver of twelve servos and four pressure channels follows 200 commands a second: beside a loop that only sleeps,
// with what it takes of a processor, and with every command and every answer counted.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sinew/ActuatorCommand.h>
#include <sinew/ActuatorState.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "callback_thread.h"
#include "control_loop.h"
#include "node_process.h"
#include "quantile.h"
#include "results.h"
#include "ros_main.h"

namespace sinew {
namespace {

constexpr double kRate = 200;               // Hz
constexpr double kUsual = 60, kFull = 600;  // s that count
constexpr double kPatience = 60;            // s until the driver is ready
constexpr double kWarmUp = 3;               // s
constexpr double kProcessorShare = 15;      // % of a core
constexpr double kLatest =
    1e3 * 0.5 / kRate;  // ms by which the driver may be less regular than the loop: half a period

double duration() {
  return std::getenv("SINEW_FULL") != nullptr ? kFull : kUsual;
}

/// s of processor time of all threads of a process (proc(5), stat: utime and stime).
double readProcessorTime(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string field;
  std::getline(file, field, ')');
  double ticks = 0;
  for (int n = 3; n <= 15 && file >> field; ++n)
    if (n >= 14) ticks += std::stod(field);
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// Commands small motions of everything, and listens.
class Line {
 public:
  Line() : commands_(node_.advertise<ActuatorCommand>("actuator_command", 10)) {
    states_ = node_.subscribe("actuator_state", 1000, &Line::onState, this, ros::TransportHints().tcpNoDelay());
    periods.reserve(static_cast<std::size_t>(2 * kRate * duration()));
    message_.session = 7;
  }

  bool waitUntilReady() const {
    for (const double begin = steadyNow(); steadyNow() - begin < kPatience; ros::WallDuration(0.05).sleep())
      if (driver_state_ == ActuatorState::READY) return true;
    return false;
  }

  /// One command every period; keeps the pace of the steady clock.
  void lead(double seconds) {
    PeriodicWakeUp wake_up(1 / kRate);
    const auto cycles = static_cast<std::uint64_t>(seconds * kRate);
    for (std::uint64_t n = 0; n < cycles; ++n) {
      wake_up.wait();
      phase_ += 1 / kRate;
      ++message_.sequence;
      for (std::size_t i = 0; i < message_.value.size(); ++i) {
        const bool pressure = message_.mode[i] == ActuatorCommand::PRESSURE;
        message_.value[i] =
            base_[i] +
            (pressure ? 10000 : 0.005) *
                (1 - std::cos(2 * phase_ + static_cast<double>(i)) - (1 - std::cos(static_cast<double>(i)))) * ramp();
      }
      commands_.publish(message_);
      ++published;
    }
  }

  void count(bool counts) { counts_ = counts; }
  ActuatorState newest() const { return newest_; }

  std::uint64_t published = 0;
  std::atomic<std::uint64_t> states{0}, invalid{0}, inactive{0};
  std::vector<double> periods;  // s between cycles, by the driver's stamps

 private:
  double ramp() const { return std::min(1., phase_ / 2); }

  void onState(const ActuatorState& state) {
    if (driver_state_ != ActuatorState::READY && state.driver_state == ActuatorState::READY) {
      message_.name = state.name;
      message_.mode = state.mode;
      message_.value = base_ = state.measured;
    }
    driver_state_ = state.driver_state;
    newest_ = state;
    if (!counts_) {
      last_ = ros::Time();
      return;
    }
    ++states;
    inactive += state.driver_state != ActuatorState::ACTIVE;
    for (const auto valid : state.measured_valid) invalid += valid == 0;
    if (!last_.isZero() && periods.size() < periods.capacity()) periods.push_back((state.header.stamp - last_).toSec());
    last_ = state.header.stamp;
  }

  ros::NodeHandle node_;
  ros::Publisher commands_;
  ros::Subscriber states_;
  ActuatorCommand message_;
  ActuatorState newest_;
  std::vector<double> base_;
  std::atomic<int> driver_state_{ActuatorState::OFF};
  std::atomic<bool> counts_{false};
  ros::Time last_;
  double phase_ = 0;
};

std::vector<double> deviations(const std::vector<double>& periods) {
  std::vector<double> result;
  for (const double period : periods) result.push_back(std::abs(period - 1 / kRate));
  return result;
}

void expectRegular(const Line& line, const ControlLoop& control) {
  const std::vector<double> own = deviations(line.periods), loop = deviations(control.periods());
  for (const double q : {0.5, 0.99, 1.0})
    std::printf("period off by p%.0f: driver %.3f ms, control loop %.3f ms\n", 100 * q, 1e3 * calcQuantile(own, q),
                1e3 * calcQuantile(loop, q));
  expectAtMost("bus_load.jitter_p99", 1e3 * calcQuantile(own, 0.99), 1e3 * calcQuantile(loop, 0.99) + kLatest, "ms");
}

TEST(BusLoad, EveryFrameIsAccountedForAndTheDriverIsLight) {
  const double seconds = duration();
  Line line;
  CallbackThread callbacks(*ros::getGlobalCallbackQueue());
  callbacks.start();
  ASSERT_TRUE(line.waitUntilReady());
  line.lead(kWarmUp);
  const ActuatorState before = line.newest();
  const std::uint64_t published_before = line.published;
  const pid_t driver = findProcess(ros::names::resolve("hardware_driver"));
  ControlLoop control(kRate);
  control.start();
  line.count(true);
  const double processor = readProcessorTime(driver), begin = steadyNow();
  line.lead(seconds);
  const double share = 100 * (readProcessorTime(driver) - processor) / (steadyNow() - begin);
  line.count(false);
  control.stop();
  ros::WallDuration(0.2).sleep();
  callbacks.stop();

  const ActuatorState after = line.newest();
  expectAtMost("bus_load.processor", share, kProcessorShare, "%");
  expectRegular(line, control);
  const auto commanded = static_cast<double>(line.published - published_before);
  const auto accepted = static_cast<double>(after.accepted - before.accepted);
  const double refused =
      static_cast<double>(after.rejected_session + after.rejected_sequence + after.rejected_malformed +
                          after.rejected_not_finite + after.rejected_state);
  // The command that was under way when counting began may fall on either side.
  expectAtMost("bus_load.commands_lost", std::abs(commanded - accepted), 1, "1");
  expectAtMost("bus_load.commands_refused", refused, 0, "1");
  const auto damaged = static_cast<double>(after.bus_corrupted - before.bus_corrupted);
  const auto missing = static_cast<double>(after.bus_missing - before.bus_missing);
  expectAtMost("bus_load.answers_damaged", damaged, 0, "1");
  // A reading is missing for no other reason than an answer that was late, and each of those is counted.
  expectAtMost("bus_load.readings_without_reason", std::max(0., static_cast<double>(line.invalid) - 16 * missing), 0,
               "1");
  expectAtMost("bus_load.answers_missing", missing, 1e-3 * commanded * 13, "1");
  expectAtMost("bus_load.inactive", static_cast<double>(line.inactive), 0, "1");
  EXPECT_GT(line.states, static_cast<std::uint64_t>(0.95 * seconds * kRate));
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  return sinew::runTestsAsNode(argc, argv, "bus_load_test");
}
