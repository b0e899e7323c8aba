#pragma once

#include <string>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// Reads a Gmsh file of format 4.1 as it is: lengths in the file's unit, tetrahedra in the file's order and
/// orientation, nodes in the order of their tags. Tetrahedra are elements of type 4; others are passed over, but
/// second-order ones are refused. Region: the first physical group of the volume, 0 without one. Throws ConfigError.
TetMesh readGmsh(const std::string& path);

}  // namespace sinew
