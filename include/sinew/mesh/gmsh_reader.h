#pragma once

#include <string>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// Reads a Gmsh file of format 4.1 as it is: lengths in the file's unit, tetrahedra in the file's order and
/// orientation, nodes in the order of their tags. Tetrahedra are elements of type 4; others are passed over, but
/// tetrahedra of higher order are refused. Region: the first physical group of the volume, 0 without one and for the
/// parts of a partitioned mesh. Throws ConfigError.
TetMesh readGmsh(const std::string& path);

}  // namespace sinew
