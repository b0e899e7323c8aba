#pragma once

#include <string>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// Reads a VTK legacy file, versions 1.0 to 5.1, as it is: lengths in the file's unit, tetrahedra in the file's order
/// and orientation. Tetrahedra are cells of type 10; cells of other types are passed over, but second-order ones are
/// refused. Throws ConfigError.
TetMesh readVtk(const std::string& path);

}  // namespace sinew
