#include "sinew/inverse/obstacle.h"

#include "sinew/common/config_error.h"
#include "sinew/mesh/stl_reader.h"

namespace sinew {
namespace {

ObstacleShape makeMeshShape(const ObstacleGeometry& geometry) {
  const StlMesh stl = readStl(geometry.mesh_file);
  TriangleMesh mesh{stl.vertices, stl.triangles};
  for (Vec3& vertex : mesh.vertices) vertex = vertex.cwiseProduct(geometry.scale);
  try {
    return ObstacleShape::makeMesh(mesh);
  } catch (const ConfigError& error) {
    throw ConfigError(geometry.mesh_file + ": " + error.what());
  }
}

ObstacleShape makeShape(const ObstacleGeometry& geometry) {
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
  return makeMeshShape(geometry);
}

}  // namespace

Obstacle makeObstacle(const ObstacleDescription& description) {
  Obstacle obstacle;
  obstacle.name = description.name;
  obstacle.pose = description.pose;
  obstacle.tracked = description.tracked;
  for (const ObstacleGeometry& geometry : description.geometries) {
    obstacle.parts.push_back({makeShape(geometry), geometry.origin});
  }
  return obstacle;
}

}  // namespace sinew
