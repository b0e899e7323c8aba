#include "sinew/contact/mesh_distance.h"

#include <cmath>

#include "sinew/common/config_error.h"
#include "sinew/contact/closest_point.h"

namespace sinew {
namespace {

constexpr double kOnBoundary = 1e-12;  // weight of a corner below which a point lies on the opposite edge
constexpr double kTouching = 1e-12;    // m

std::vector<Vec3> selectVertices(const CollisionSurface& surface, const std::vector<Vec3>& nodes) {
  std::vector<Vec3> selected;
  selected.reserve(static_cast<std::size_t>(surface.vertices()));
  for (int v = 0; v < surface.vertices(); ++v) selected.push_back(nodes.at(surface.node(v)));
  return selected;
}

double calcVolume(const CollisionSurface& surface, const std::vector<Vec3>& x) {
  double volume = 0;
  for (const auto& t : surface.triangles()) volume += x[t[0]].dot(x[t[1]].cross(x[t[2]])) / 6;
  return volume;
}

}  // namespace

MeshDistance::MeshDistance(const std::vector<Vec3>& vertices, const std::vector<CollisionSurface::Triangle>& triangles)
    : surface_(triangles),
      vertices_(selectVertices(surface_, vertices)),
      edge_normals_(surface_.edges().size(), Vec3::Zero()),
      vertex_normals_(vertices_.size(), Vec3::Zero()),
      tree_(surface_.triangles(), vertices_) {
  const double volume = calcVolume(surface_, vertices_);
  if (!(volume > 0)) {
    throw ConfigError("obstacle mesh: enclosed volume", std::to_string(volume), "positive: normals point outwards");
  }
  makeNormals();
}

void MeshDistance::makeNormals() {
  for (int t = 0; t < static_cast<int>(surface_.triangles().size()); ++t) {
    const Vec3 cross = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
    if (!(cross.norm() > 0)) {
      throw ConfigError("obstacle mesh: triangle " + std::to_string(t), "no area", "three corners not in line");
    }
    const Vec3 normal = cross.normalized();
    face_normals_.push_back(normal);
    for (int i = 0; i < 3; ++i) {
      const Vec3 next = corner(t, (i + 1) % 3) - corner(t, i);
      const Vec3 previous = corner(t, (i + 2) % 3) - corner(t, i);
      const double angle = std::atan2(next.cross(previous).norm(), next.dot(previous));
      vertex_normals_[surface_.triangles()[t][i]] += angle * normal;
      edge_normals_[surface_.edgesOf(t)[i]] += normal;
    }
  }
}

Vec3 MeshDistance::pseudoNormal(int triangle, const Vec3& weights) const {
  for (int i = 0; i < 3; ++i) {
    if (weights[i] >= 1 - kOnBoundary) return vertex_normals_[surface_.triangles()[triangle][i]];
  }
  for (int i = 0; i < 3; ++i) {
    if (weights[(i + 2) % 3] <= kOnBoundary) return edge_normals_[surface_.edgesOf(triangle)[i]];
  }
  return face_normals_[triangle];
}

SurfaceDistance MeshDistance::calcDistance(const Vec3& p) const {
  int nearest = -1;
  double least = 1e300;
  Vec3 weights = Vec3::UnitX();
  tree_.forEachNear(p, [&](int t) {
    const Vec3 w = calcClosestWeights(corner(t, 0), corner(t, 1), corner(t, 2), p);
    const double squared = (w[0] * corner(t, 0) + w[1] * corner(t, 1) + w[2] * corner(t, 2) - p).squaredNorm();
    if (squared < least) {
      least = squared;
      nearest = t;
      weights = w;
    }
    return squared;
  });
  SurfaceDistance result;
  result.point = weights[0] * corner(nearest, 0) + weights[1] * corner(nearest, 1) + weights[2] * corner(nearest, 2);
  const Vec3 outward = pseudoNormal(nearest, weights);
  const Vec3 offset = p - result.point;
  const double side = offset.dot(outward) >= 0 ? 1 : -1;
  result.distance = side * offset.norm();
  result.normal = offset.norm() > kTouching ? Vec3(side * offset.normalized()) : Vec3(outward.normalized());
  return result;
}

}  // namespace sinew
