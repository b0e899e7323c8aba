#pragma once

#include <cmath>

#include "mesh/bar_mesh.h"
#include "sinew/fem/fem_model.h"

namespace sinew {

/// A box of one material, its nodes at x = 0 fixed.
struct BarModel {
  TetMesh mesh;
  FemModel fem;

  BarModel(const Vec3& size, int nx, int ny, int nz, double young_modulus, double poisson_ratio, double density)
      : mesh(makeBarMesh(size, nx, ny, nz)),
        fem(mesh, material(young_modulus, poisson_ratio, density), clamped(), {}) {}

  std::vector<Material> material(double young_modulus, double poisson_ratio, double density) const {
    return std::vector<Material>(mesh.tets.size(), Material{calcLame(young_modulus, poisson_ratio), density});
  }

  std::vector<bool> clamped() const {
    std::vector<bool> fixed;
    for (const Vec3& node : mesh.nodes) fixed.push_back(node.x() < 1e-12);
    return fixed;
  }
};

}  // namespace sinew
