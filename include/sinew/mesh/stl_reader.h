#pragma once

#include <array>
#include <string>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// A triangle surface with vertices that triangles share.
struct StlMesh {
  std::vector<Vec3> vertices;                 ///< unit of the file
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// Reads an STL file, ASCII or binary. Corners with the same coordinates, to the last bit, become one vertex, in the
/// order of their first appearance; triangles with two corners in one vertex are passed over. Throws ConfigError that
/// names file, place and reason.
StlMesh readStl(const std::string& path);

}  // namespace sinew
