#pragma once

#include <array>
#include <memory>
#include <vector>

#include "sinew/contact/mesh_distance.h"
#include "sinew/contact/surface_distance.h"

namespace sinew {

/// A closed triangle mesh: corners counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< m
  std::vector<CollisionSurface::Triangle> triangles;
};

/// A rigid shape in its own frame, lengths in m:
///   plane     the half space z <= 0
///   sphere    about the origin
///   box       |x|, |y|, |z| <= half sizes
///   cylinder  about the z axis, |z| <= length / 2
///   mesh      whatever its triangles enclose
class ObstacleShape {
 public:
  enum class Kind { kPlane, kSphere, kBox, kCylinder, kMesh };

  /// Throw ConfigError for sizes that are not positive and finite, and for meshes that are not closed.
  static ObstacleShape makePlane();
  static ObstacleShape makeSphere(double radius);
  static ObstacleShape makeBox(const Vec3& half_sizes);
  static ObstacleShape makeCylinder(double radius, double length);
  static ObstacleShape makeMesh(const TriangleMesh& mesh);

  Kind kind() const { return kind_; }
  double radius() const { return half_.x(); }               ///< of sphere and cylinder
  const Vec3& halfSizes() const { return half_; }           ///< of the enclosing box; not of the plane
  const MeshDistance* mesh() const { return mesh_.get(); }  ///< of kMesh, otherwise null

  /// Whether the distance is that of plane, sphere or cylinder: smooth, but for the rims of the cylinder.
  bool isSmooth() const { return kind_ != Kind::kBox && kind_ != Kind::kMesh; }

  /// Exact for all shapes; `p` in the shape's frame. Where several points are nearest, one of them.
  SurfaceDistance calcDistance(const Vec3& p) const;
  /// Bounds the shape with its frame at `pose`. The plane's box ends at the plane only where an axis is its normal.
  Box calcBox(const Pose& pose) const;
  /// The part of the line p + t d (frame of the shape, d unit) inside a convex shape (not a mesh) that is grown by
  /// `margin` [m] on every side: box and cylinder keep their corners. False where the line misses it.
  bool calcChord(const Vec3& p, const Vec3& d, double margin, double* enter, double* leave) const;

  /// Triangles for display: exact for box and mesh, inscribed with about `divisions` sides for sphere and cylinder; the
  /// plane is a square slab of side `plane_size` [m].
  TriangleMesh makeTriangles(int divisions, double plane_size = 1) const;

 private:
  ObstacleShape(Kind kind, const Vec3& half) : kind_(kind), half_(half) {}

  Kind kind_;
  Vec3 half_;
  std::shared_ptr<const MeshDistance> mesh_;
};

}  // namespace sinew
