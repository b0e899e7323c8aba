#pragma once

#include <ros/node_handle.h>
#include <std_msgs/Header.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <optional>
#include <string>

#include "refusal_log.h"
#include "sinew/common/types.h"

namespace sinew {

/// Brings what messages say, in whatever frame, into the robot's frame by tf.
class FrameFinder {
 public:
  /// `tolerance` [s]: by how much a message may be newer than the newest transform of its frame.
  FrameFinder(ros::NodeHandle node, std::string robot_frame, double tolerance);

  /// The pose of the header's frame in the robot's at the header's stamp, the newest one for a stamp of 0.
  std::optional<Refusal> find(const std_msgs::Header& header, Pose& to_robot) const;

  const std::string& robotFrame() const { return robot_frame_; }

 private:
  std::string robot_frame_;
  double tolerance_;  // s
  tf2_ros::Buffer transforms_;
  tf2_ros::TransformListener listener_;
};

/// Whether a message's stamp is within `timeout` [s] of now, before or after; a stamp of 0 always is.
std::optional<Refusal> checkStamp(const std_msgs::Header& header, double timeout);

}  // namespace sinew
