#include <ros/console.h>
#include <ros/init.h>

#include <exception>
#include <memory>

#include "callback_thread.h"
#include "inverse_model_node.h"

int main(int argc, char** argv) {
  // Before ros::start: the threads that carry the messages inherit it.
  const std::string not_allowed = sinew::requestRealTime();
  ros::init(argc, argv, "inverse_model");
  ros::start();
  std::unique_ptr<sinew::InverseModelNode> node;
  try {
    const sinew::NormalPriority while_building;
    node = std::make_unique<sinew::InverseModelNode>(ros::NodeHandle(), ros::NodeHandle("~"));
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  if (!not_allowed.empty()) ROS_WARN_STREAM("not in real time: " << not_allowed << "; deadlines may be missed");
  sinew::spinUntilShutdown();
  return 0;
}
