#include "sinew/contact/collision_surface.h"

#include <gtest/gtest.h>

#include "contact/shapes.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

TEST(CollisionSurface, SatisfiesEulerAndOwnsEveryFeatureOnce) {
  const TriangleMesh fork = makeFork(Vec3(3, 1, 2));
  const CollisionSurface surface(fork.triangles);
  const int faces = static_cast<int>(surface.triangles().size());
  const int edges = static_cast<int>(surface.edges().size());
  EXPECT_EQ(surface.vertices() - edges + faces, 2);
  std::vector<int> vertex_owners(surface.vertices(), 0), edge_owners(edges, 0);
  for (int t = 0; t < faces; ++t) {
    for (const int v : surface.ownedVertices(t)) ++vertex_owners[v];
    for (const int e : surface.ownedEdges(t)) ++edge_owners[e];
  }
  for (const int count : vertex_owners) EXPECT_EQ(count, 1);
  for (const int count : edge_owners) EXPECT_EQ(count, 1);
}

TEST(CollisionSurface, LinksEdgesTrianglesAndNodes) {
  const TriangleMesh fork = makeFork(Vec3(3, 1, 2));
  const CollisionSurface surface(fork.triangles);
  for (int t = 0; t < static_cast<int>(fork.triangles.size()); ++t) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(surface.node(surface.triangles()[t][i]), fork.triangles[t][i]);
      const CollisionSurface::Edge& edge = surface.edges()[surface.edgesOf(t)[i]];
      const int from = surface.triangles()[t][i], to = surface.triangles()[t][(i + 1) % 3];
      const bool is_first = edge.triangles[0] == t;
      EXPECT_EQ(edge.vertices[is_first ? 0 : 1], from);
      EXPECT_EQ(edge.vertices[is_first ? 1 : 0], to);
      EXPECT_EQ(edge.opposite[is_first ? 0 : 1], surface.triangles()[t][(i + 2) % 3]);
      EXPECT_TRUE(surface.areNeighbours(from, to));
    }
  }
  EXPECT_FALSE(surface.areNeighbours(0, 0));
}

TEST(CollisionSurface, RefusesWhatIsNotClosedOrNotOriented) {
  TriangleMesh mesh = makeTetrahedron(1);
  TriangleMesh open = mesh, turned = mesh;
  open.triangles.pop_back();
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_THROW(CollisionSurface{open.triangles}, ConfigError);
  EXPECT_THROW(CollisionSurface{turned.triangles}, ConfigError);
  EXPECT_THROW(CollisionSurface{{}}, ConfigError);
}

}  // namespace
}  // namespace sinew
