#include "sinew/contact/proximity_detection.h"

#include <algorithm>

namespace sinew {
namespace {

std::unique_ptr<MovingSurface> makeSurface(const ObstacleShape& shape) {
  if (shape.isSmooth()) return nullptr;
  const TriangleMesh mesh = shape.makeTriangles(0);
  return std::make_unique<MovingSurface>(CollisionSurface(mesh.triangles), mesh.vertices);
}

const ProximitySettings& checked(const ProximitySettings& settings) {
  settings.check();
  return settings;
}

}  // namespace

ProximityDetection::ProximityDetection(const ProximitySettings& settings, const CollisionSurface& topology,
                                       const std::vector<Vec3>& rest, const std::vector<ObstacleShape>& obstacles,
                                       int max_rows)
    : settings_(checked(settings)),
      max_rows_(max_rows),
      surface_(topology, rest),
      most_vertices_(countMostVertices(obstacles)),
      smooth_pairs_(settings, topology),
      surface_pairs_(settings, topology.vertices(), most_vertices_, max_rows),
      own_near_(settings, surface_, surface_) {
  for (const ObstacleShape& shape : obstacles) {
    obstacles_.push_back({shape, makeSurface(shape), nullptr});
    Obstacle& obstacle = obstacles_.back();
    if (obstacle.surface == nullptr) continue;
    obstacle.near = std::make_unique<NearPairs>(settings, surface_, *obstacle.surface);
  }
}

int ProximityDetection::countMostVertices(const std::vector<ObstacleShape>& obstacles) {
  int most = 0;
  for (const ObstacleShape& shape : obstacles) {
    if (!shape.isSmooth()) most = std::max(most, static_cast<int>(shape.makeTriangles(0).vertices.size()));
  }
  return most;
}

void ProximityDetection::reserveOther(int max_other_vertices) {
  most_vertices_ = std::max(most_vertices_, max_other_vertices);
  surface_pairs_ = SurfacePairs(settings_, surface_.topology().vertices(), most_vertices_, max_rows_);
}

void ProximityDetection::addObstacle(int index, const Pose& pose, ContactList& list) {
  Obstacle& obstacle = obstacles_[index];
  if (obstacle.surface == nullptr) {
    smooth_pairs_.addPairs(surface_, obstacle.shape, pose, index, list);
    return;
  }
  obstacle.surface->updateRigid(pose);
  surface_pairs_.addPairs(surface_, *obstacle.surface, obstacle.near.get(), index, list);
}

void ProximityDetection::addSelf(const RegionPairs& regions, ContactList& list) {
  surface_pairs_.addOwnPairs(surface_, &own_near_, regions, list);
}

bool ProximityDetection::addOther(const MovingSurface& other, ContactList& list) {
  if (other.topology().vertices() > most_vertices_) return false;
  surface_pairs_.addPairs(surface_, other, nullptr, kOtherSurface, list);
  return true;
}

}  // namespace sinew
