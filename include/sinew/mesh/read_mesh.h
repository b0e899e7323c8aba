#pragma once

#include <string>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// Reads the tetrahedra of a VTK legacy (`.vtk`, ASCII or binary, any mix of cells) or Gmsh 4.1 (`.msh`, ASCII or
/// binary) file; cells of other kinds are passed over, and tetrahedra of negative volume are turned. `scale` converts
/// the file's length unit to metres (1e-3 for mm). Region tags come from the cell array `region` (VTK) or the first
/// physical group of the volume (Gmsh).
///
/// Nodes keep the file's numbering from 0, including those that no tetrahedron uses: VTK points in their order, Gmsh
/// nodes in the order of their tags (node tag 1 is node 0 where tags count from 1 without gaps).
/// Throws ConfigError that names file, place and reason.
TetMesh readMesh(const std::string& path, double scale);

}  // namespace sinew
