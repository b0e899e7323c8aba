#pragma once

#include <array>
#include <string>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/robot/region_description.h"

namespace sinew {

/// One rigid shape of an obstacle.
struct ObstacleGeometry {
  enum class Kind { kPlane, kSphere, kBox, kCylinder, kMesh };
  Kind kind = Kind::kSphere;
  Pose origin = Pose::Identity();  ///< of the shape in the obstacle's frame
  double radius = 0;               ///< m, of a sphere or cylinder
  double length = 0;               ///< m, of a cylinder, along its z axis
  Vec3 size = Vec3::Zero();        ///< m, edges of a box
  std::string mesh_file;           ///< STL, a closed surface with normals outwards
  Vec3 scale = Vec3::Ones();       ///< m per unit of the mesh file
};

/// A rigid body that the robot may touch. A plane is the half space below z = 0 of its own frame.
struct ObstacleDescription {
  std::string name;
  std::vector<ObstacleGeometry> geometries;
  Pose pose = Pose::Identity();  ///< in the robot's frame, until something else is heard
  bool tracked = false;          ///< its pose is heard while running, and it may be absent
};

enum class DetectionMethod { kProximity, kVolume };

/// How contacts are found.
struct ContactDescription {
  DetectionMethod method = DetectionMethod::kProximity;
  double alarm_distance = 0.005;    ///< m below which two surfaces are watched
  double contact_distance = 0.001;  ///< m that stays between them
  bool self = false;                ///< whether the robot may touch itself
  /// Which regions may touch which, as indices into `regions`; empty: every part of the robot every other.
  std::vector<std::array<int, 2>> self_pairs;
  std::vector<RegionDescription> regions;  ///< of the robot's surface
  int max_contacts = 100;                  ///< the closest so many are kept
  int resolution = 64;                     ///< pixels of the volume method along the longest side
};

/// The collision geometry of link `link` of a URDF, in the link's frame. Throws ConfigError when the file cannot be
/// read, the link is not in it or has no collision geometry.
std::vector<ObstacleGeometry> readUrdfCollision(const std::string& urdf_file, const std::string& link);

}  // namespace sinew
