#pragma once

#include <ros/node_handle.h>

#include <chrono>
#include <mutex>

#include "panel_model.h"

namespace sinew {

/// Keeps the newest message of a topic and when it came. Filled by whatever thread serves the node's callback queue.
template <typename Message>
class MessageInbox {
 public:
  /// Forgets what was heard and listens to another topic.
  void subscribe(ros::NodeHandle& node, const std::string& topic) {
    subscriber_.shutdown();  // returns when a callback under way has ended
    newest_.reset();
    subscriber_ = node.subscribe(topic, 1, &MessageInbox::receive, this, ros::TransportHints().tcpNoDelay());
  }

  Heard<Message> newest() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return {newest_, std::chrono::duration<double>(Clock::now() - received_).count()};
  }

 private:
  using Clock = std::chrono::steady_clock;

  void receive(const boost::shared_ptr<const Message>& message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    newest_ = message;
    received_ = Clock::now();
  }

  mutable std::mutex mutex_;
  boost::shared_ptr<const Message> newest_;
  Clock::time_point received_;
  ros::Subscriber subscriber_;
};

}  // namespace sinew
