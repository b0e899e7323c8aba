#include "sinew/mesh/read_mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <utility>

#include "sinew/common/config_error.h"
#include "sinew/mesh/gmsh_reader.h"
#include "sinew/mesh/vtk_reader.h"

namespace sinew {
namespace {

TetMesh readByExtension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".vtk") return readVtk(path);
  if (extension == ".msh") return readGmsh(path);
  throw ConfigError(path, "a file name ending in '" + extension + "'",
                    ".vtk (VTK legacy) or .msh (Gmsh 4.1); scripts/convert_mesh converts other files");
}

void scaleNodes(TetMesh& mesh, double scale, const std::string& path) {
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    mesh.nodes[i] *= scale;
    if (!mesh.nodes[i].allFinite()) {
      throw ConfigError(path + ", node " + std::to_string(i), "a coordinate that is not a number", "finite lengths");
    }
  }
}

void turnInvertedTets(TetMesh& mesh) {
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (tetVolume(mesh, static_cast<int>(t)) < 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  }
}

}  // namespace

TetMesh readMesh(const std::string& path, double scale) {
  if (!(std::isfinite(scale) && scale > 0)) {
    throw ConfigError("scale of " + path, std::to_string(scale), "metres per unit of the file: 0.001 if it is in mm");
  }
  TetMesh mesh = readByExtension(path);
  if (mesh.tets.empty()) {
    throw ConfigError(path, "no tetrahedra",
                      "a volume mesh; scripts/convert_mesh fills a closed surface with tetrahedra");
  }
  scaleNodes(mesh, scale, path);
  turnInvertedTets(mesh);
  return mesh;
}

}  // namespace sinew
