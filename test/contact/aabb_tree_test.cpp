#include "sinew/contact/aabb_tree.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "contact/shapes.h"

namespace sinew {
namespace {

Box boxOf(const TriangleMesh& mesh, std::size_t t) {
  Box box;
  for (const int corner : mesh.triangles[t]) box.extend(mesh.vertices[corner]);
  return box;
}

double calcDistance(const Box& a, const Box& b) {
  return (a.lower - b.upper).cwiseMax(b.lower - a.upper).cwiseMax(Vec3::Zero()).norm();
}

TEST(AabbTree, FindsExactlyThePairsOfBoxesWithinTheMargin) {
  Random random(1);
  TriangleMesh a = makeBall(0.02, 2), b = makeBar(Vec3(0.04, 0.02, 0.02), 4, 2, 2);
  AabbTree tree_a(a.triangles, a.vertices), tree_b(b.triangles, b.vertices);
  for (int i = 0; i < 20; ++i) {
    a.vertices = calcMoved(a.vertices, random.pose(0.01));
    tree_a.refit(a.triangles, a.vertices);
    std::set<std::pair<int, int>> found, expected;
    tree_a.forEachPair(tree_b, 2e-3, [&](int ta, int tb) { EXPECT_TRUE(found.insert({ta, tb}).second); });
    for (std::size_t ta = 0; ta < a.triangles.size(); ++ta) {
      for (std::size_t tb = 0; tb < b.triangles.size(); ++tb) {
        if (calcDistance(boxOf(a, ta), boxOf(b, tb)) <= 2e-3) expected.insert({ta, tb});
      }
    }
    EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));
    EXPECT_LE(found.size(), expected.size() + expected.size() / 100 + 2) << "rounding may add a pair, no more";
  }
}

TEST(AabbTree, MeetsEveryPairOfItsOwnOnceAndKnowsItsBox) {
  const TriangleMesh mesh = makeBall(0.02, 1);
  const AabbTree tree(mesh.triangles, mesh.vertices);
  std::set<std::pair<int, int>> found;
  tree.forEachOwnPair(1, [&](int a, int b) { EXPECT_TRUE(found.insert(std::minmax(a, b)).second); });
  EXPECT_EQ(found.size(), mesh.triangles.size() * (mesh.triangles.size() - 1) / 2);
  EXPECT_LT((tree.box().upper - Vec3::Constant(0.02)).norm(), 1e-15);
}

TEST(AabbTree, LeavesOutOwnPairsThatLookTheSameWay) {
  const TriangleMesh mesh = makeBall(0.02, 2);
  AabbTree tree(mesh.triangles, mesh.vertices);
  std::vector<Box> normals(mesh.triangles.size());
  std::vector<Vec3> normal;
  for (std::size_t t = 0; t < normals.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const Vec3& x = mesh.vertices[corners[0]];
    normal.push_back((mesh.vertices[corners[1]] - x).cross(mesh.vertices[corners[2]] - x).normalized());
    normals[t].extend(normal.back());
  }
  tree.refitNormals(normals);
  std::set<std::pair<int, int>> found;
  tree.forEachOwnPair(1, [&](int a, int b) { found.insert(std::minmax(a, b)); });
  int opposed = 0;
  for (int a = 0; a < static_cast<int>(normal.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(normal.size()); ++b) {
      if (normal[a].dot(normal[b]) > -1e-6) continue;
      ++opposed;
      EXPECT_EQ(found.count({a, b}), 1u);
    }
  }
  EXPECT_LE(found.size(), opposed * 1.1);
}

}  // namespace
}  // namespace sinew
