#include "sinew/mesh/surface.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

#include "mesh/bar_mesh.h"

namespace sinew {
namespace {

const Vec3 kSize(0.3, 0.2, 0.1);

const Vec3& nodeOf(const TetMesh& mesh, int node) {
  return mesh.nodes[static_cast<std::size_t>(node)];
}

/// Divergence theorem: the volume inside a closed surface is the sum of a . (b x c) / 6.
double calcEnclosedVolume(const TetMesh& mesh, const Surface& surface) {
  double volume = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    volume += nodeOf(mesh, a).dot(nodeOf(mesh, b).cross(nodeOf(mesh, c))) / 6;
  }
  return volume;
}

double calcArea(const TetMesh& mesh, const Surface& surface) {
  double area = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    area += (nodeOf(mesh, b) - nodeOf(mesh, a)).cross(nodeOf(mesh, c) - nodeOf(mesh, a)).norm() / 2;
  }
  return area;
}

TEST(Surface, OfABoxHasItsAreaAndEnclosesItsVolume) {
  const TetMesh mesh = makeBarMesh(kSize, 4, 3, 2);
  const Surface surface = makeBoundarySurface(mesh);
  EXPECT_EQ(surface.triangles.size(), 4u * (4 * 3 + 3 * 2 + 2 * 4));
  EXPECT_NEAR(calcArea(mesh, surface), 2 * (0.06 + 0.02 + 0.03), 1e-14);
  EXPECT_NEAR(calcEnclosedVolume(mesh, surface), kSize.prod(), 1e-15);
}

TEST(Surface, OfASingleTetrahedronPointsOutwardOnEverySide) {
  TetMesh mesh;
  mesh.nodes = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  mesh.tets = {{0, 1, 2, 3}};
  const Vec3 center(0.25, 0.25, 0.25);
  const Surface surface = makeBoundarySurface(mesh);
  ASSERT_EQ(surface.triangles.size(), 4u);
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 normal = (nodeOf(mesh, b) - nodeOf(mesh, a)).cross(nodeOf(mesh, c) - nodeOf(mesh, a));
    EXPECT_GT(normal.dot(nodeOf(mesh, a) - center), 0);
  }
}

TEST(Surface, HasEveryEdgeOnceInEachDirection) {
  const Surface surface = makeBoundarySurface(makeBarMesh(kSize, 3, 2, 2));
  std::map<std::pair<int, int>, int> uses;
  for (const auto& triangle : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++uses[{triangle[i], triangle[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : uses) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(uses.count({edge.second, edge.first}), 1u);
  }
}

TEST(Surface, ListsExactlyTheNodesOnTheBox) {
  const TetMesh mesh = makeBarMesh(kSize, 4, 4, 3);
  std::vector<int> expected;
  for (int i = 0; i < static_cast<int>(mesh.nodes.size()); ++i) {
    const Vec3& node = nodeOf(mesh, i);
    const bool on_lower = node.minCoeff() < 1e-9;
    const bool on_upper = (kSize - node).minCoeff() < 1e-9;
    if (on_lower || on_upper) expected.push_back(i);
  }
  EXPECT_EQ(makeBoundarySurface(mesh).nodes, expected);
}

TEST(Surface, SortedFacesPutSharedFacesSideBySide) {
  const TetMesh mesh = makeBarMesh(kSize, 2, 2, 2);
  const std::vector<TetFace> faces = makeSortedFaces(mesh);
  ASSERT_EQ(faces.size(), 4 * mesh.tets.size());
  std::map<std::array<int, 3>, int> uses;
  std::set<std::array<int, 3>> closed;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    EXPECT_EQ(closed.count(faces[i].corners), 0u) << "a face comes back after others";
    if (i + 1 < faces.size() && faces[i + 1].corners != faces[i].corners) closed.insert(faces[i].corners);
    ++uses[faces[i].corners];
  }
  for (const auto& use : uses) EXPECT_LE(use.second, 2);
}

}  // namespace
}  // namespace sinew
