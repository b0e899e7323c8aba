#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "mesh/bar_mesh.h"
#include "sinew/contact/obstacle_shape.h"
#include "sinew/mesh/surface.h"

namespace sinew {

inline TriangleMesh makeTetrahedron(double size) {
  return {{Vec3(0, 0, 0), Vec3(size, 0, 0), Vec3(0, size, 0), Vec3(0, 0, size)},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

/// The boundary of a set of cells of a bar: convex if all are kept, with re-entrant edges otherwise.
template <typename Keep>
TriangleMesh makeCells(const Vec3& size, int nx, int ny, int nz, const Keep& keep) {
  TetMesh mesh = makeBarMesh(size, nx, ny, nz);
  TetMesh kept;
  kept.nodes = mesh.nodes;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const int cell = static_cast<int>(t) / 6;
    if (keep(cell % nx, cell / nx % ny, cell / (nx * ny))) kept.tets.push_back(mesh.tets[t]);
  }
  TriangleMesh surface = {kept.nodes, makeBoundarySurface(kept).triangles};
  return surface;
}

inline TriangleMesh makeBar(const Vec3& size, int nx, int ny, int nz) {
  return makeCells(size, nx, ny, nz, [](int, int, int) { return true; });
}

/// A U of 3 x 1 x 2 cells.
inline TriangleMesh makeFork(const Vec3& size) {
  return makeCells(size, 3, 1, 2, [](int i, int, int k) { return k == 0 || i != 1; });
}

/// An octahedron, each face split into four `levels` times, on a sphere.
inline TriangleMesh makeBall(double radius, int levels) {
  TriangleMesh mesh = {{Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()},
                       {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    std::vector<CollisionSurface::Triangle> finer;
    const auto middle = [&](int a, int b) {
      const auto key = std::make_pair(std::min(a, b), std::max(a, b));
      if (middles.count(key) == 0) {
        middles[key] = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      }
      return middles[key];
    };
    for (const auto& t : mesh.triangles) {
      const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    mesh.triangles = finer;
  }
  for (Vec3& x : mesh.vertices) x *= radius;
  return mesh;
}

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double uniform(double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(generator_);
  }
  int index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(generator_); }
  Vec3 vector(double reach) { return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)}; }
  Vec3 direction() {
    Vec3 v;
    do v = vector(1);
    while (v.norm() > 1 || v.norm() < 0.1);
    return v.normalized();
  }
  Pose pose(double reach) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(uniform(-M_PI, M_PI), direction()).toRotationMatrix();
    pose.translation() = vector(reach);
    return pose;
  }

 private:
  std::mt19937 generator_;
};

inline std::vector<Vec3> calcMoved(const std::vector<Vec3>& x, const Pose& pose) {
  std::vector<Vec3> moved;
  for (const Vec3& p : x) moved.push_back(pose * p);
  return moved;
}

}  // namespace sinew
