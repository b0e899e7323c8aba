#include <cstdlib>

#include "sinew/common/config_error.h"
#include "sinew/robot/obstacle_description.h"
#include "urdf_model.h"

namespace sinew {
namespace {

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

std::string folderOf(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string::npos ? "." : file.substr(0, slash);
}

/// A path as a URDF may give it: absolute, file://, or relative to the URDF.
std::string resolve(const std::string& urdf_file, const std::string& key, const std::string& name) {
  if (startsWith(name, "package://")) {
    throw ConfigError(key, "'" + name + "'", "file:// and an absolute path, or a path relative to the URDF");
  }
  const std::string path = startsWith(name, "file://") ? name.substr(7) : name;
  return startsWith(path, "/") ? path : folderOf(urdf_file) + "/" + path;
}

ObstacleGeometry readGeometry(const urdf::Geometry& shape, const std::string& urdf_file, const std::string& key) {
  ObstacleGeometry geometry;
  switch (shape.type) {
    case urdf::Geometry::SPHERE:
      geometry.kind = ObstacleGeometry::Kind::kSphere;
      geometry.radius = static_cast<const urdf::Sphere&>(shape).radius;
      break;
    case urdf::Geometry::BOX: {
      const urdf::Vector3& size = static_cast<const urdf::Box&>(shape).dim;
      geometry.kind = ObstacleGeometry::Kind::kBox;
      geometry.size = Vec3(size.x, size.y, size.z);
      break;
    }
    case urdf::Geometry::CYLINDER:
      geometry.kind = ObstacleGeometry::Kind::kCylinder;
      geometry.radius = static_cast<const urdf::Cylinder&>(shape).radius;
      geometry.length = static_cast<const urdf::Cylinder&>(shape).length;
      break;
    case urdf::Geometry::MESH: {
      const auto& mesh = static_cast<const urdf::Mesh&>(shape);
      geometry.kind = ObstacleGeometry::Kind::kMesh;
      geometry.mesh_file = resolve(urdf_file, key + ".mesh", mesh.filename);
      geometry.scale = Vec3(mesh.scale.x, mesh.scale.y, mesh.scale.z);
      break;
    }
  }
  return geometry;
}

}  // namespace

std::vector<ObstacleGeometry> readUrdfCollision(const std::string& urdf_file, const std::string& link) {
  const urdf::ModelInterfaceSharedPtr model = readUrdf(urdf_file);
  const std::string key = urdf_file + ": link '" + link + "': collision";
  std::vector<ObstacleGeometry> geometries;
  for (const urdf::CollisionSharedPtr& collision : findLink(*model, urdf_file, link)->collision_array) {
    if (!collision->geometry) throw ConfigError(key, "no geometry", "a box, cylinder, sphere or mesh");
    geometries.push_back(readGeometry(*collision->geometry, urdf_file, key));
    geometries.back().origin = toPose(collision->origin);
  }
  if (geometries.empty()) throw ConfigError(key, "none", "one collision element or more with a geometry");
  return geometries;
}

}  // namespace sinew
