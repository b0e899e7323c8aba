#include "sinew/inverse/obstacle.h"

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

ObstacleShape makeShape(const ObstacleDescription& obstacle, const ObstacleGeometry& geometry) {
  switch (geometry.kind) {
    case ObstacleGeometry::Kind::kPlane:
      return ObstacleShape::makePlane();
    case ObstacleGeometry::Kind::kSphere:
      return ObstacleShape::makeSphere(geometry.radius);
    case ObstacleGeometry::Kind::kBox:
      return ObstacleShape::makeBox(0.5 * geometry.size);
    case ObstacleGeometry::Kind::kCylinder:
      return ObstacleShape::makeCylinder(geometry.radius, geometry.length);
    case ObstacleGeometry::Kind::kMesh:
      break;
  }
  throw ConfigError("obstacle '" + obstacle.name + "'", "a mesh, " + geometry.mesh_file,
                    "a box, cylinder, sphere or plane");
}

}  // namespace

Obstacle makeObstacle(const ObstacleDescription& description) {
  Obstacle obstacle;
  obstacle.name = description.name;
  obstacle.pose = description.pose;
  obstacle.tracked = description.tracked;
  for (const ObstacleGeometry& geometry : description.geometries) {
    obstacle.parts.push_back({makeShape(description, geometry), geometry.origin});
  }
  return obstacle;
}

}  // namespace sinew
