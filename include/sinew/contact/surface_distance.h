#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// A shape seen from a point.
struct SurfaceDistance {
  double distance;  ///< m, negative inside
  Vec3 normal;      ///< unit, the gradient of the distance: out of the shape
  Vec3 point;       ///< of the shape's surface, nearest: where seen from = point + distance * normal
};

}  // namespace sinew
