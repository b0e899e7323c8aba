#pragma once

#include <functional>
#include <random>

#include "mesh/bar_mesh.h"
#include "sinew/constraint/cable.h"

namespace sinew {

/// A bar clamped at x = 0 with three points embedded along it, and the couplings that a cable through them needs.
struct CableBar {
  TetMesh mesh = makeBarMesh(Vec3(0.09, 0.02, 0.02), 6, 2, 2);
  std::vector<EmbeddedPoint> points;
  CableDescription description;
  FemModel fem;

  CableBar() : points(locate()), fem(mesh, makeMaterials(), makeFixed(), makeCouplings()) {
    description.pull_point = Vec3(-0.01, 0.013, 0.008);
  }

  std::vector<EmbeddedPoint> locate() const {
    const PointLocator locator(mesh);
    std::vector<EmbeddedPoint> found;
    for (const Vec3& position : {Vec3(0.004, 0.012, 0.011), Vec3(0.041, 0.016, 0.006), Vec3(0.083, 0.009, 0.014)}) {
      found.push_back(locator.locate(position).point);
    }
    return found;
  }

  std::vector<Material> makeMaterials() const {
    return std::vector<Material>(mesh.tets.size(), Material{calcLame(1e5, 0.3), 1000});
  }

  std::vector<bool> makeFixed() const {
    std::vector<bool> fixed;
    for (const Vec3& node : mesh.nodes) fixed.push_back(node.x() < 1e-12);
    return fixed;
  }

  std::vector<std::vector<int>> makeCouplings() const {
    return {SegmentStiffness::coupledNodes(nullptr, points[0]), SegmentStiffness::coupledNodes(&points[0], points[1]),
            SegmentStiffness::coupledNodes(&points[1], points[2]), SegmentStiffness::coupledNodes(nullptr, points[2])};
  }

  /// The free nodes stretched by `stretch` along x, and scattered by 1 mm.
  std::vector<Vec3> makeDeformed(unsigned seed, double stretch) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1e-3);
    std::vector<Vec3> positions = mesh.nodes;
    for (int node : fem.freeNodes()) {
      positions[node].x() *= stretch;
      positions[node] += Vec3(normal(random), normal(random), normal(random));
    }
    return positions;
  }

  /// Column k: central difference of `function` by degree of freedom k.
  MatX differentiate(const std::function<VecX(const std::vector<Vec3>&)>& function, std::vector<Vec3> positions) const {
    constexpr double kStep = 1e-6;  // m
    MatX derivative(function(positions).size(), fem.size());
    for (int k = 0; k < fem.size(); ++k) {
      double& x = positions[fem.freeNodes()[k / 3]][k % 3];
      const double at = x;
      x = at + kStep;
      const VecX above = function(positions);
      x = at - kStep;
      derivative.col(k) = (above - function(positions)) / (2 * kStep);
      x = at;
    }
    return derivative;
  }
};

/// Row `row` of H, dense.
inline VecX makeDenseRow(const ConstraintRows& rows, int row, int size) {
  VecX dense = VecX::Zero(size);
  rows.addTransposed(row, 1, dense);
  return dense;
}

}  // namespace sinew
