#pragma once

#include <array>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/contact/aabb_tree.h"
#include "sinew/contact/collision_surface.h"

namespace sinew {

/// A collision surface where it is in this cycle: positions, normals and the tree of boxes. `update` allocates nothing.
class MovingSurface {
 public:
  /// `rest` are the node positions [m] at rest, where no part of the surface passes through another.
  MovingSurface(const CollisionSurface& topology, const std::vector<Vec3>& rest);

  void update(const std::vector<Vec3>& nodes);
  /// The rest configuration moved as a rigid body.
  void updateRigid(const Pose& pose);

  const CollisionSurface& topology() const { return topology_; }
  const AabbTree& tree() const { return tree_; }
  const Vec3& position(int vertex) const { return positions_[vertex]; }
  const Vec3& rest(int vertex) const { return rest_[vertex]; }
  const Vec3& corner(int triangle, int i) const { return positions_[topology_.triangles()[triangle][i]]; }

  const Vec3& faceNormal(int triangle) const { return face_normals_[triangle]; }  ///< unit; zero without an area
  const Vec3& vertexNormal(int vertex) const { return vertex_normals_[vertex]; }  ///< weighted by angle, any length
  const Vec3& edgeNormal(int edge) const { return edge_normals_[edge]; }          ///< sum of both faces'

  double faceArea(int triangle) const { return face_areas_[triangle]; }
  double edgeArea(int edge) const;                                       ///< a third of its two triangles [m2]
  double vertexArea(int vertex) const { return vertex_areas_[vertex]; }  ///< a third of its triangles [m2]

  /// Unit vector in face `i` (0 or 1) of an edge, at a right angle to it, away from it.
  Vec3 calcInward(int edge, int i) const;
  /// Sine of the angle by which the surface bends around an edge: positive convex, negative concave, 0 flat.
  double bend(int edge) const { return bends_[edge]; }
  /// Whether `p` lies above or below the triangle, up to rounding; its weights there.
  bool projectsInto(int triangle, const Vec3& p, Vec3* weights) const;

  /// How the surface leaves a point of it along direction `d` (unit): the smallest slope of d . x over the directions
  /// that stay on the surface, exactly so along the edges of a vertex and across an edge. Where it is >= 0 the point is
  /// the lowest of its surroundings along d.
  double calcVertexSlope(int vertex, const Vec3& d) const;
  double calcEdgeSlope(int edge, const Vec3& d) const;

 private:
  void updateNormals();
  void updateEdges();
  void updateDirections();

  CollisionSurface topology_;
  std::vector<Vec3> rest_, positions_;  // by vertex
  std::vector<Vec3> face_normals_, edge_normals_, vertex_normals_;
  std::vector<double> face_areas_, vertex_areas_, bends_;
  std::vector<Box> directions_;  // by triangle: around the unit normals of its features
  AabbTree tree_;
};

}  // namespace sinew
