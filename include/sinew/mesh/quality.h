#pragma once

#include <string>
#include <vector>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// What a look at a mesh finds before a robot moves. Every message gives the count, the index of one example (the worst
/// where there is a worst) and what would be right.
struct MeshReport {
  /// The mesh cannot be simulated: no tetrahedra, indices out of range, inverted or flat tetrahedra, faces shared by
  /// more than two.
  std::vector<std::string> errors;
  /// Suspicious: unused or duplicated nodes, another number of pieces than expected, pieces that hang together by a
  /// node or an edge only, slivers, a size that looks like mm or is very small.
  std::vector<std::string> warnings;
  int tets = 0;
  int nodes = 0;
  int pieces = 0;             ///< sets of tetrahedra that share no node
  std::vector<int> piece;     ///< of each node; -1 where no tetrahedron has it
  double volume = 0;          ///< m3
  Vec3 lower = Vec3::Zero();  ///< bounding box of the nodes, m
  Vec3 upper = Vec3::Zero();  ///< bounding box of the nodes, m
  double worst_quality = 0;   ///< smallest calcTetQuality
};

/// Looks at everything that can be seen without a material. Any content of `mesh` is allowed.
MeshReport checkMesh(const TetMesh& mesh, int expected_pieces = 1);

/// Mean ratio 12 (3 V)^(2/3) / (sum of the six squared edges) of tetrahedron `t`: 1 for a regular tetrahedron, 0 for a
/// flat or inverted one; below 0.2 it is called a sliver.
double calcTetQuality(const TetMesh& mesh, int t);

}  // namespace sinew
