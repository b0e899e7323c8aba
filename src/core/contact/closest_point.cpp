#include "sinew/contact/closest_point.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr double kParallel = 1e-6;  // sine below which two lines have no crossing

Vec3 calcClosestWeightsOnEdges(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 corners[3] = {a, b, c};
  Vec3 best = Vec3::UnitX();
  double least = (a - p).squaredNorm();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const double t = calcClosestParameter(corners[i], corners[j], p);
    const double squared = ((1 - t) * corners[i] + t * corners[j] - p).squaredNorm();
    if (squared >= least) continue;
    least = squared;
    best.setZero();
    best[i] = 1 - t;
    best[j] = t;
  }
  return best;
}

}  // namespace

Vec3 calcClosestWeights(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 normal = (b - a).cross(c - a);
  const double squared_norm = normal.squaredNorm();
  if (squared_norm > 0) {
    const double wb = normal.dot((p - a).cross(c - a)) / squared_norm;
    const double wc = normal.dot((b - a).cross(p - a)) / squared_norm;
    if (wb >= 0 && wc >= 0 && wb + wc <= 1) return {1 - wb - wc, wb, wc};
  }
  return calcClosestWeightsOnEdges(a, b, c, p);
}

double calcClosestParameter(const Vec3& a, const Vec3& b, const Vec3& p) {
  const double squared = (b - a).squaredNorm();
  if (!(squared > 0)) return 0;
  return std::min(1.0, std::max(0.0, (b - a).dot(p - a) / squared));
}

LineMeeting calcLineMeeting(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 u = a1 - a0;
  const Vec3 v = b1 - b0;
  const Vec3 normal = u.cross(v);
  const double squared = normal.squaredNorm();
  if (!(squared > kParallel * kParallel * u.squaredNorm() * v.squaredNorm())) return {true, 0, 0, Vec3::Zero()};
  const Vec3 w = b0 - a0;
  return {false, w.cross(v).dot(normal) / squared, w.cross(u).dot(normal) / squared, normal / std::sqrt(squared)};
}

}  // namespace sinew
