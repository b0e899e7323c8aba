#include "callback_thread.h"

#include <ros/init.h>

namespace sinew {

namespace {

const ros::WallDuration kPatience(0.1);  // s until a thread looks whether it is to end

bool isOpen() {
  return ros::ok() && !ros::isShuttingDown();
}

}  // namespace

void spinUntilShutdown() {
  while (isOpen()) ros::getGlobalCallbackQueue()->callAvailable(kPatience);
  while (ros::ok()) ros::WallDuration(0.01).sleep();  // until the shutdown is complete
}

void CallbackThread::start() {
  running_ = true;
  thread_ = std::thread([this] {
    while (running_ && isOpen()) queue_.callAvailable(kPatience);
  });
}

void CallbackThread::stop() {
  running_ = false;
  if (thread_.joinable()) thread_.join();
}

}  // namespace sinew
