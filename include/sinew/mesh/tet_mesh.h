#pragma once

#include <array>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// A tetrahedral mesh at rest. Tetrahedra have positive volume: (n1 - n0) x (n2 - n0) . (n3 - n0) > 0.
struct TetMesh {
  std::vector<Vec3> nodes;               ///< m
  std::vector<std::array<int, 4>> tets;  ///< node indices
  std::vector<int> region;               ///< one tag per tetrahedron, 0 where the file has none
};

/// Signed volume of tetrahedron `t` [m3].
double tetVolume(const TetMesh& mesh, int t);

}  // namespace sinew
