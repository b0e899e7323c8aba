#include "sinew/mesh/embedding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "mesh/bar_mesh.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

const Vec3 kSize(0.12, 0.06, 0.09);

Vec3 calcPosition(const TetMesh& mesh, const EmbeddedPoint& point) {
  Vec3 position = Vec3::Zero();
  for (int i = 0; i < 4; ++i) {
    position += point.weights[i] * mesh.nodes[static_cast<std::size_t>(point.nodes[static_cast<std::size_t>(i)])];
  }
  return position;
}

/// Smallest of the four volumes that `p` spans with the sides of tetrahedron `t`, over the volume of `t`.
double calcSmallestVolumeRatio(TetMesh mesh, int t, const Vec3& p) {
  const double volume = tetVolume(mesh, t);
  mesh.nodes.push_back(p);
  double smallest = std::numeric_limits<double>::infinity();
  for (int& corner : mesh.tets[static_cast<std::size_t>(t)]) {
    const int kept = std::exchange(corner, static_cast<int>(mesh.nodes.size()) - 1);
    smallest = std::min(smallest, tetVolume(mesh, t) / volume);
    corner = kept;
  }
  return smallest;
}

/// An L: the box without its upper half in x and z.
TetMesh makeCornerMesh() {
  TetMesh mesh = makeBarMesh(kSize, 6, 2, 4);
  TetMesh corner;
  corner.nodes = mesh.nodes;
  for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) {
    Vec3 center = Vec3::Zero();
    for (const int node : mesh.tets[static_cast<std::size_t>(t)])
      center += mesh.nodes[static_cast<std::size_t>(node)] / 4;
    if (center.x() > kSize.x() / 2 && center.z() > kSize.z() / 2) continue;
    corner.tets.push_back(mesh.tets[static_cast<std::size_t>(t)]);
    corner.region.push_back(0);
  }
  return corner;
}

Vec3 clampTo(const Vec3& p, const Vec3& upper) {
  return p.cwiseMax(Vec3::Zero()).cwiseMin(upper);
}

/// The point of the L nearest to `p`: the L is the union of two boxes.
Vec3 calcNearestOfCorner(const Vec3& p) {
  const Vec3 low = clampTo(p, Vec3(kSize.x(), kSize.y(), kSize.z() / 2));
  const Vec3 left = clampTo(p, Vec3(kSize.x() / 2, kSize.y(), kSize.z()));
  return (low - p).norm() < (left - p).norm() ? low : left;
}

class EmbeddingOfRandomPoints : public testing::Test {
 protected:
  Vec3 draw(double around) {
    std::uniform_real_distribution<double> unit(-around, 1 + around);
    return kSize.cwiseProduct(Vec3(unit(random_), unit(random_), unit(random_)));
  }
  std::mt19937 random_{7};
};

TEST_F(EmbeddingOfRandomPoints, InsideHasPositiveWeightsAndNoDistance) {
  const TetMesh mesh = makeBarMesh(kSize, 6, 4, 5);
  const PointLocator locator(mesh);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = draw(0);
    const PointLocator::Result result = locator.locate(p);
    EXPECT_EQ(result.distance, 0);
    EXPECT_GE(result.point.weights.minCoeff(), 0);
    EXPECT_NEAR(result.point.weights.sum(), 1, 1e-15);
    EXPECT_EQ(result.point.nodes, mesh.tets[static_cast<std::size_t>(result.tet)]);
    EXPECT_NEAR((calcPosition(mesh, result.point) - p).norm(), 0, 1e-15);
    EXPECT_GE(calcSmallestVolumeRatio(mesh, result.tet, p), -1e-12);
  }
}

TEST_F(EmbeddingOfRandomPoints, OutsideIsCarriedByTheNearestTetrahedron) {
  const TetMesh mesh = makeCornerMesh();
  const PointLocator locator(mesh);
  int outside = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = draw(1);
    const Vec3 nearest = calcNearestOfCorner(p);
    const PointLocator::Result result = locator.locate(p);
    EXPECT_NEAR(result.distance, (nearest - p).norm(), 1e-12);
    EXPECT_GE(calcSmallestVolumeRatio(mesh, result.tet, nearest), -1e-9);
    EXPECT_NEAR((calcPosition(mesh, result.point) - p).norm(), 0, 1e-12);
    outside += result.distance > 0 ? 1 : 0;
  }
  EXPECT_GT(outside, 2000);
}

TEST(Embedding, OfANodeIsThatNode) {
  const TetMesh mesh = makeBarMesh(kSize, 3, 2, 2);
  const PointLocator locator(mesh);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const PointLocator::Result result = locator.locate(mesh.nodes[i]);
    EXPECT_NEAR(result.distance, 0, 1e-15);
    Eigen::Index largest;
    EXPECT_NEAR(result.point.weights.maxCoeff(&largest), 1, 1e-12);
    EXPECT_EQ(result.point.nodes[static_cast<std::size_t>(largest)], static_cast<int>(i));
  }
}

TEST(Embedding, ExtrapolatesAsLittleAsItCan) {
  const TetMesh mesh = makeBarMesh(kSize, 4, 3, 3);
  const Vec3 p = kSize + Vec3(0.004, 0.005, 0.006);  // nearest to the corner node, which several tetrahedra share
  const PointLocator::Result result = PointLocator(mesh).locate(p);
  const int corner = static_cast<int>(mesh.nodes.size()) - 1;
  for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) {
    const std::array<int, 4>& tet = mesh.tets[static_cast<std::size_t>(t)];
    if (std::find(tet.begin(), tet.end(), corner) == tet.end()) continue;
    EXPECT_GE(result.point.weights.minCoeff(), calcSmallestVolumeRatio(mesh, t, p) - 1e-9);
  }
}

TEST(Embedding, ReproducesAPointNearAThinTetrahedron) {
  TetMesh mesh;
  mesh.nodes = {Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0), Vec3(0.03, 0.04, 1e-6)};
  mesh.tets = {{0, 1, 2, 3}};
  const Vec3 p(0.02, -0.03, 0.05);
  const PointLocator::Result result = PointLocator(mesh).locate(p);
  EXPECT_NEAR((calcPosition(mesh, result.point) - p).norm(), 0, 1e-12);
  EXPECT_NEAR(result.distance, std::hypot(0.03, 0.05), 1e-7);
}

TEST(Embedding, PassesOverFlatTetrahedra) {
  TetMesh mesh = makeBarMesh(kSize, 1, 1, 1);
  mesh.tets.insert(mesh.tets.begin(), {0, 1, 1, 2});
  const PointLocator::Result result = PointLocator(mesh).locate(kSize / 3);
  EXPECT_GT(result.tet, 0);
  EXPECT_EQ(result.distance, 0);
}

TEST(Embedding, RefusesAMeshWithoutVolumeAndPointsThatAreNotFinite) {
  EXPECT_THROW(PointLocator{TetMesh()}, ConfigError);
  const PointLocator locator(makeBarMesh(kSize, 1, 1, 1));
  EXPECT_THROW(locator.locate(Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0)), ConfigError);
  EXPECT_THROW(locator.locate(Vec3(0, 0, std::numeric_limits<double>::infinity())), ConfigError);
}

}  // namespace
}  // namespace sinew
