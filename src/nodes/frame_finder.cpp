#include "frame_finder.h"

#include <tf2_eigen/tf2_eigen.h>

#include <cmath>
#include <sstream>
#include <utility>

namespace sinew {

FrameFinder::FrameFinder(ros::NodeHandle node, std::string robot_frame, double tolerance)
    : robot_frame_(std::move(robot_frame)), tolerance_(tolerance), listener_(transforms_, node) {}

std::optional<Refusal> FrameFinder::find(const std_msgs::Header& header, Pose& to_robot) const {
  to_robot.setIdentity();
  if (header.frame_id == robot_frame_) return std::nullopt;
  const auto look_up = [&](const ros::Time& time) {
    const geometry_msgs::TransformStamped transform = transforms_.lookupTransform(robot_frame_, header.frame_id, time);
    to_robot = tf2::transformToEigen(transform);
    return transform.header.stamp;
  };
  try {
    try {
      look_up(header.stamp);
    } catch (const tf2::ExtrapolationException&) {
      // A message may overtake the transform of its own moment: then the newest one will do, if it is recent.
      const ros::Time found = look_up(ros::Time(0));
      if (std::abs((header.stamp - found).toSec()) > tolerance_) throw;
    }
  } catch (const tf2::TransformException& error) {
    const std::string from = header.frame_id.empty() ? "a frame without a name" : "frame '" + header.frame_id + "'";
    return Refusal{RefusalReason::kUnknownFrame,
                   "no transform from " + from + " to '" + robot_frame_ + "': " + error.what()};
  }
  return std::nullopt;
}

std::optional<Refusal> checkStamp(const std_msgs::Header& header, double timeout) {
  if (header.stamp.isZero()) return std::nullopt;
  const double age = (ros::Time::now() - header.stamp).toSec();
  if (std::abs(age) <= timeout) return std::nullopt;
  std::ostringstream words;
  words << "its stamp is " << std::abs(age) << " s " << (age > 0 ? "old" : "ahead of this clock") << ", more than "
        << timeout << " s";
  return Refusal{RefusalReason::kStamp, words.str()};
}

}  // namespace sinew
