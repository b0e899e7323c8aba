#pragma once

#include <algorithm>
#include <array>

#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// A solid box [0, size] (m) of nx * ny * nz cells, x fastest: node (i, j, k) has index i + (nx + 1) (j + (ny + 1) k).
/// Kuhn subdivision: each cell is six tetrahedra, one for each monotone path of edges between its opposite corners, so
/// that neighbouring cells share whole faces.
inline TetMesh makeBarMesh(const Vec3& size, int nx, int ny, int nz) {
  TetMesh mesh;
  const auto node = [&](const std::array<int, 3>& at) { return at[0] + (nx + 1) * (at[1] + (ny + 1) * at[2]); };
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        mesh.nodes.emplace_back(size.x() * i / nx, size.y() * j / ny, size.z() * k / nz);
      }
    }
  }
  for (int cell = 0; cell < nx * ny * nz; ++cell) {
    std::array<int, 3> axes = {0, 1, 2};
    do {
      std::array<int, 3> at = {cell % nx, cell / nx % ny, cell / (nx * ny)};
      std::array<int, 4> tet;
      tet[0] = node(at);
      for (std::size_t step = 0; step < 3; ++step) {
        ++at[static_cast<std::size_t>(axes[step])];
        tet[step + 1] = node(at);
      }
      const bool even = (axes[1] - axes[0] + 3) % 3 == 1;
      if (!even) std::swap(tet[1], tet[2]);
      mesh.tets.push_back(tet);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  mesh.region.assign(mesh.tets.size(), 0);
  return mesh;
}

}  // namespace sinew
