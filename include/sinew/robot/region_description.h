#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// A part of a robot at rest: what lies in any of its shapes, borders included.
struct RegionDescription {
  struct Box {
    Vec3 min, max;  ///< m
  };
  struct Sphere {
    Vec3 centre;    ///< m
    double radius;  ///< m
  };
  std::string name;
  std::vector<Box> boxes;
  std::vector<Sphere> spheres;

  bool contains(const Vec3& point) const {
    return std::any_of(boxes.begin(), boxes.end(),
                       [&](const Box& box) {
                         return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
                       }) ||
           std::any_of(spheres.begin(), spheres.end(),
                       [&](const Sphere& sphere) { return (point - sphere.centre).norm() <= sphere.radius; });
  }
};

}  // namespace sinew
