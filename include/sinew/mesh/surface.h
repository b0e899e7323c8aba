#pragma once

#include <array>
#include <vector>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// A triangle surface whose corners are nodes of a tetrahedral mesh, normals pointing out of the material.
struct Surface {
  std::vector<int> nodes;                     ///< mesh nodes on the surface, ascending
  std::vector<std::array<int, 3>> triangles;  ///< mesh node indices, counter-clockwise seen from outside
};

/// The faces of `mesh` that belong to exactly one tetrahedron, in the order of the tetrahedra. All tetrahedra must have
/// positive volume.
Surface makeBoundarySurface(const TetMesh& mesh);

/// One face of one tetrahedron.
struct TetFace {
  std::array<int, 3> corners;  ///< mesh node indices, ascending: the same for both tetrahedra that share the face
  int tet;
  int side;  ///< row of kTetSides
};

/// Corners of the four faces of a tetrahedron of positive volume, counter-clockwise seen from outside.
constexpr std::array<std::array<int, 3>, 4> kTetSides = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// All 4 n faces of the n tetrahedra, sorted by corners so that shared faces are neighbours in the list.
std::vector<TetFace> makeSortedFaces(const TetMesh& mesh);

}  // namespace sinew
