#include "sinew/mesh/surface.h"

#include <algorithm>
#include <tuple>

namespace sinew {
namespace {

std::array<int, 3> calcCorners(const TetMesh& mesh, int tet, int side) {
  const std::array<int, 4>& nodes = mesh.tets[static_cast<std::size_t>(tet)];
  std::array<int, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    corners[i] = nodes[static_cast<std::size_t>(kTetSides[static_cast<std::size_t>(side)][i])];
  }
  return corners;
}

bool isSameFace(const TetFace& a, const TetFace& b) {
  return a.corners == b.corners;
}

std::vector<TetFace> selectUnshared(const std::vector<TetFace>& faces) {
  std::vector<TetFace> unshared;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool like_previous = i > 0 && isSameFace(faces[i - 1], faces[i]);
    const bool like_next = i + 1 < faces.size() && isSameFace(faces[i], faces[i + 1]);
    if (!like_previous && !like_next) unshared.push_back(faces[i]);
  }
  return unshared;
}

std::vector<int> collectNodes(const std::vector<std::array<int, 3>>& triangles) {
  std::vector<int> nodes;
  for (const std::array<int, 3>& triangle : triangles) nodes.insert(nodes.end(), triangle.begin(), triangle.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace

std::vector<TetFace> makeSortedFaces(const TetMesh& mesh) {
  std::vector<TetFace> faces;
  faces.reserve(4 * mesh.tets.size());
  for (int tet = 0; tet < static_cast<int>(mesh.tets.size()); ++tet) {
    for (int side = 0; side < 4; ++side) {
      std::array<int, 3> corners = calcCorners(mesh, tet, side);
      std::sort(corners.begin(), corners.end());
      faces.push_back({corners, tet, side});
    }
  }
  std::sort(faces.begin(), faces.end(), [](const TetFace& a, const TetFace& b) {
    return std::tie(a.corners, a.tet, a.side) < std::tie(b.corners, b.tet, b.side);
  });
  return faces;
}

Surface makeBoundarySurface(const TetMesh& mesh) {
  std::vector<TetFace> faces = selectUnshared(makeSortedFaces(mesh));
  std::sort(faces.begin(), faces.end(),
            [](const TetFace& a, const TetFace& b) { return std::tie(a.tet, a.side) < std::tie(b.tet, b.side); });
  Surface surface;
  for (const TetFace& face : faces) surface.triangles.push_back(calcCorners(mesh, face.tet, face.side));
  surface.nodes = collectNodes(surface.triangles);
  return surface;
}

}  // namespace sinew
