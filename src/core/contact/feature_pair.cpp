#include "sinew/contact/feature_pair.h"

#include <cmath>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

void require(bool holds, const char* name, double found, const char* expected) {
  if (!holds || !std::isfinite(found)) {
    throw ConfigError(std::string("contact detection: ") + name, std::to_string(found), expected);
  }
}

}  // namespace

SurfacePoint SurfacePoint::atVertex(const MovingSurface& surface, int vertex) {
  return {1, {vertex, 0, 0}, {1, 0, 0}, surface.position(vertex)};
}

SurfacePoint SurfacePoint::onEdge(const MovingSurface& surface, int edge, double t) {
  const auto& ends = surface.topology().edges()[edge].vertices;
  return {2, {ends[0], ends[1], 0}, {1 - t, t, 0}, (1 - t) * surface.position(ends[0]) + t * surface.position(ends[1])};
}

SurfacePoint SurfacePoint::onFace(const MovingSurface& surface, int triangle, const Vec3& weights) {
  const auto& corners = surface.topology().triangles()[triangle];
  return {3,
          {corners[0], corners[1], corners[2]},
          {weights[0], weights[1], weights[2]},
          weights[0] * surface.position(corners[0]) + weights[1] * surface.position(corners[1]) +
              weights[2] * surface.position(corners[2])};
}

Vec3 SurfacePoint::calcRestPosition(const MovingSurface& surface) const {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < vertices; ++i) sum += weight[i] * surface.rest(vertex[i]);
  return sum;
}

void ProximitySettings::check() const {
  require(contact_distance > 0, "contact_distance", contact_distance, "greater than 0 m");
  require(alarm_distance > contact_distance, "alarm_distance", alarm_distance, "greater than contact_distance");
  require(slope >= 0 && slope < 1, "slope", slope, "0 to 1");
  require(max_depth >= 0, "max_depth", max_depth, "0 m or greater");
  require(hysteresis >= 0, "hysteresis", hysteresis, "0 or greater");
}

}  // namespace sinew
