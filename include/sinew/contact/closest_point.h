#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// Weights of the corners of a triangle at a point of it: all >= 0, sum 1.
/// The point of triangle abc nearest to p. A triangle without area is treated as its edges.
Vec3 calcClosestWeights(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p);

/// Parameter t in [0, 1] of the point a + t (b - a) nearest to p.
double calcClosestParameter(const Vec3& a, const Vec3& b, const Vec3& p);

/// Where two straight lines a0 + s (a1 - a0) and b0 + t (b1 - b0) come closest.
struct LineMeeting {
  bool is_parallel;
  double s, t;
  Vec3 across;  ///< unit, (a1 - a0) x (b1 - b0)
};
LineMeeting calcLineMeeting(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1);

}  // namespace sinew
