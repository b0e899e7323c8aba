#pragma once

#include <array>
#include <vector>

#include "sinew/contact/aabb_tree.h"
#include "sinew/contact/collision_surface.h"
#include "sinew/contact/surface_distance.h"

namespace sinew {

/// Signed distance to a closed triangle mesh that does not move. The sign comes from the normal of the nearest feature:
/// of a face, of both faces of an edge, of a vertex's faces weighted by their angle (Baerentzen and Aanaes, Signed
/// distance computation using the angle weighted pseudonormal, IEEE TVCG 11(3), 2005).
class MeshDistance {
 public:
  /// Throws ConfigError unless the mesh is closed, with outward normals and no flat triangle.
  MeshDistance(const std::vector<Vec3>& vertices, const std::vector<CollisionSurface::Triangle>& triangles);

  SurfaceDistance calcDistance(const Vec3& p) const;
  const Box& box() const { return tree_.box(); }
  const std::vector<Vec3>& vertices() const { return vertices_; }
  const CollisionSurface& surface() const { return surface_; }

 private:
  void makeNormals();
  Vec3 pseudoNormal(int triangle, const Vec3& weights) const;
  const Vec3& corner(int triangle, int i) const { return vertices_[surface_.triangles()[triangle][i]]; }

  CollisionSurface surface_;
  std::vector<Vec3> vertices_;  // by vertex of surface_
  std::vector<Vec3> face_normals_, edge_normals_, vertex_normals_;
  AabbTree tree_;
};

}  // namespace sinew
