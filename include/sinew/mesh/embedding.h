#pragma once

#include <array>
#include <memory>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// A point carried by one tetrahedron: position = sum_i weight_i * node_i (thesis 1.3.3). Weights sum to 1; all are
/// >= 0 for a point inside, and extrapolate for a point outside.
struct EmbeddedPoint {
  std::array<int, 4> nodes{};
  Vec4 weights = Vec4::Zero();
};

/// Finds the tetrahedron that carries a point of the rest configuration. For set-up: `locate` walks a bounding-box tree
/// that is built once, O(n log n).
class PointLocator {
 public:
  /// Copies what it needs of `mesh`; flat tetrahedra carry no points. Throws ConfigError if none is left.
  explicit PointLocator(const TetMesh& mesh);
  ~PointLocator();

  struct Result {
    EmbeddedPoint point;  ///< reproduces the query position exactly, by extrapolation when outside
    int tet = -1;
    double distance = 0;  ///< m from the mesh, 0 inside
  };
  /// The tetrahedron that contains `position` [m], or else the nearest one. Among equally near ones (on a shared face,
  /// edge or node) it is the one whose smallest weight is largest, so that a point is extrapolated as little as can be.
  /// Throws ConfigError if `position` is not finite.
  Result locate(const Vec3& position) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
