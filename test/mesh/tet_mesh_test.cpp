#include "sinew/mesh/tet_mesh.h"

#include <gtest/gtest.h>

#include "mesh/bar_mesh.h"

namespace sinew {
namespace {

TEST(TetMesh, VolumeHasTheSignOfTheOrientation) {
  TetMesh mesh;
  mesh.nodes = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 4)};
  mesh.tets = {{0, 1, 2, 3}, {0, 2, 1, 3}};
  EXPECT_DOUBLE_EQ(tetVolume(mesh, 0), 4);
  EXPECT_DOUBLE_EQ(tetVolume(mesh, 1), -4);
}

TEST(BarMesh, FillsTheBoxWithEqualTetrahedra) {
  const TetMesh mesh = makeBarMesh(Vec3(0.2, 0.06, 0.04), 5, 3, 2);
  EXPECT_EQ(mesh.nodes.size(), 6u * 4u * 3u);
  EXPECT_EQ(mesh.tets.size(), 6u * 5u * 3u * 2u);
  EXPECT_EQ(mesh.region.size(), mesh.tets.size());
  for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) {
    EXPECT_NEAR(tetVolume(mesh, t), 0.2 * 0.06 * 0.04 / 180, 1e-18);
  }
}

TEST(BarMesh, NumbersNodesWithXFastest) {
  const TetMesh mesh = makeBarMesh(Vec3(5, 3, 2), 5, 3, 2);
  const int i = 4, j = 1, k = 2;
  EXPECT_TRUE(mesh.nodes[i + 6 * (j + 4 * k)].isApprox(Vec3(i, j, k)));
}

}  // namespace
}  // namespace sinew
