#include "sinew/contact/mesh_distance.h"

#include <gtest/gtest.h>

#include "contact/brute_force_minima.h"
#include "contact/shapes.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

TEST(MeshDistance, IsTheLeastOverAllTriangles) {
  Random random(1);
  for (const TriangleMesh& mesh : {makeFork(Vec3(3, 1, 2)), makeBall(1, 2), makeTetrahedron(2)}) {
    const MeshDistance distance(mesh.vertices, mesh.triangles);
    for (int i = 0; i < 500; ++i) {
      const Vec3 p = random.vector(3);
      double least = 1e300;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        least = std::min(least, (brute::nearestOnTriangle(cornersOf(mesh, t), p) - p).norm());
      }
      EXPECT_NEAR(std::abs(distance.calcDistance(p).distance), least, 1e-12);
    }
  }
}

TEST(MeshDistance, HasTheRightSignNearestToSharpCorners) {
  const TriangleMesh needle = {{Vec3(0, 0, 10), Vec3(1, 0, 0), Vec3(-0.5, 0.8, 0), Vec3(-0.5, -0.8, 0)},
                               {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
  const MeshDistance distance(needle.vertices, needle.triangles);
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    EXPECT_GT(distance.calcDistance(Vec3(0, 0, 10.01) + random.vector(0.009)).distance, 0);
  }
  EXPECT_LT(distance.calcDistance(Vec3(0, 0, 9.9)).distance, 0);
}

TEST(MeshDistance, RefusesFlatTrianglesAndInsideOut) {
  TriangleMesh turned = makeTetrahedron(1);
  for (auto& t : turned.triangles) std::swap(t[1], t[2]);
  EXPECT_THROW(MeshDistance(turned.vertices, turned.triangles), ConfigError);
}

}  // namespace
}  // namespace sinew
