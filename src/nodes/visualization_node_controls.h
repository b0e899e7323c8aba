#pragma once

#include <visualization_msgs/InteractiveMarkerControl.h>

#include <array>

#include "sinew/common/types.h"

namespace sinew {

/// An arrow along axis 0, 1 or 2 of an interactive marker: its x axis is turned onto that axis.
inline visualization_msgs::InteractiveMarkerControl makeAxisControl(int axis) {
  static const std::array<const char*, 3> kNames{{"move_x", "move_y", "move_z"}};
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitX(), Vec3::Unit(axis));
  visualization_msgs::InteractiveMarkerControl control;
  control.name = kNames[static_cast<std::size_t>(axis)];
  control.orientation.w = turn.w();
  control.orientation.x = turn.x();
  control.orientation.y = turn.y();
  control.orientation.z = turn.z();
  control.interaction_mode = visualization_msgs::InteractiveMarkerControl::MOVE_AXIS;
  return control;
}

}  // namespace sinew
