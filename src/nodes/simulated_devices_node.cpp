// Simulated devices without a robot: each cable pulls at a spring. For trying out drivers and tools.

#include <ros/ros.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>

#include "callback_thread.h"
#include "parameters.h"
#include "real_time.h"
#include "simulated_devices.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.002;    // s of the mechanics
constexpr int kStepsPerMessage = 5;  // 100 Hz

HardwareDescription readDescription(const Parameters& parameters) {
  HardwareDescription hardware = HardwareDescription::load(parameters.text("hardware"));
  if (parameters.has("port_link")) hardware.movePorts(parameters.text("port_link"));
  return hardware;
}

class SimulatedDevicesNode {
 public:
  SimulatedDevicesNode(ros::NodeHandle node, ros::NodeHandle private_node)
      : stiffness_(Parameters(private_node).numberOr("stiffness", 400, 0, 1e6)),
        pretension_(Parameters(private_node).numberOr("pretension", 1, 0, 1e3)),
        desk_(node, private_node, readDescription(Parameters(private_node)), LineFaults()),
        thread_([this] { run(); }) {}
  ~SimulatedDevicesNode() {
    running_ = false;
    thread_.join();
  }

 private:
  void run() {
    PeriodicWakeUp wake_up(kPeriod);
    SimulatedHardware& hardware = desk_.hardware();
    double moved_until = steadyNow();
    for (int step = 0; running_; ++step) {
      wake_up.wait();
      const double now = steadyNow();
      for (int i = 0; i < hardware.size(); ++i)
        hardware.setTension(i, std::max(0., pretension_ + stiffness_ * hardware.reeledIn(i)));
      hardware.step(now - moved_until);
      moved_until = now;
      if (step % kStepsPerMessage == 0) desk_.publish(ros::Time::now());
    }
  }

  double stiffness_;   // N/m
  double pretension_;  // N where the spools stand at the start
  SimulatedDevicesDesk desk_;
  std::atomic<bool> running_{true};
  std::thread thread_;
};

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  const std::string not_allowed = sinew::requestRealTime();
  ros::init(argc, argv, "simulated_devices");
  if (!not_allowed.empty()) ROS_WARN("on a busy machine devices may answer late: %s", not_allowed.c_str());
  try {
    sinew::SimulatedDevicesNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    sinew::spinUntilShutdown();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
}
