#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// Where a target may be dragged to: a box and a sphere, both in the robot's frame [m], either of them unbounded.
struct Workspace {
  Eigen::AlignedBox3d box{Vec3::Constant(-kUnbounded), Vec3::Constant(kUnbounded)};
  Vec3 centre = Vec3::Zero();
  double radius = kUnbounded;

  /// The nearest point of the box, moved towards the sphere's centre until it lies in the sphere as well. The centre
  /// has to lie in the box.
  Vec3 calcClamped(const Vec3& point) const {
    const Vec3 in_box = point.cwiseMax(box.min()).cwiseMin(box.max());
    const Vec3 arm = in_box - centre;
    const double length = arm.norm();
    return length > radius ? Vec3(centre + radius / length * arm) : in_box;
  }

  static constexpr double kUnbounded = 1e9;
};

}  // namespace sinew
