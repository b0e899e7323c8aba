#include <ros/console.h>
#include <ros/init.h>

#include <exception>

#include "callback_thread.h"
#include "inverse_model_node.h"

int main(int argc, char** argv) {
  // Before ros::init: the threads that roscpp starts inherit it.
  const std::string not_allowed = sinew::requestRealTime();
  ros::init(argc, argv, "inverse_model");
  try {
    sinew::InverseModelNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    if (!not_allowed.empty()) ROS_WARN_STREAM("not in real time: " << not_allowed << "; deadlines may be missed");
    sinew::spinUntilShutdown();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
