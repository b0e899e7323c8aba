#include "sinew/contact/moving_surface.h"

#include <gtest/gtest.h>

#include "contact/shapes.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

TEST(MovingSurface, OfABallHasRadialNormalsAndTheAreaOfItsTriangles) {
  const TriangleMesh ball = makeBall(1, 3);
  const MovingSurface surface(CollisionSurface(ball.triangles), ball.vertices);
  double faces = 0, edges = 0, vertices = 0;
  for (int v = 0; v < surface.topology().vertices(); ++v) {
    EXPECT_GT(surface.vertexNormal(v).normalized().dot(surface.position(v)), 0.999);
    vertices += surface.vertexArea(v);
  }
  for (int e = 0; e < static_cast<int>(surface.topology().edges().size()); ++e) {
    EXPECT_GT(surface.bend(e), 0) << "all edges of a ball are convex";
    edges += surface.edgeArea(e);
  }
  for (int t = 0; t < static_cast<int>(ball.triangles.size()); ++t) faces += surface.faceArea(t);
  EXPECT_NEAR(faces, 4 * M_PI, 0.2);
  EXPECT_NEAR(vertices, faces, 1e-12);
  EXPECT_NEAR(edges, faces, 1e-12);
}

TEST(MovingSurface, OfAForkBendsBothWaysAndNotAlongDiagonals) {
  const TriangleMesh fork = makeFork(Vec3(3, 1, 2));
  const MovingSurface surface(CollisionSurface(fork.triangles), fork.vertices);
  int convex = 0, concave = 0;
  for (int e = 0; e < static_cast<int>(surface.topology().edges().size()); ++e) {
    const double bend = surface.bend(e);
    EXPECT_TRUE(std::abs(bend) < 1e-12 || std::abs(std::abs(bend) - 1) < 1e-12) << bend;
    convex += bend > 0.5;
    concave += bend < -0.5;
    for (const int i : {0, 1}) {
      const auto& edge = surface.topology().edges()[e];
      const Vec3 across = surface.position(edge.opposite[i]) - surface.position(edge.vertices[0]);
      EXPECT_GT(surface.calcInward(e, i).dot(across), 0);
      EXPECT_NEAR(surface.calcInward(e, i).dot(surface.faceNormal(edge.triangles[i])), 0, 1e-12);
    }
  }
  EXPECT_EQ(concave, 2);
  EXPECT_GT(convex, 20);
}

TEST(MovingSurface, SlopesAreThoseOfItsEdgesAndFaces) {
  const TriangleMesh box = makeBar(Vec3(1, 1, 1), 1, 1, 1);
  const MovingSurface surface(CollisionSurface(box.triangles), box.vertices);
  EXPECT_NEAR(surface.calcVertexSlope(0, Vec3::UnitX()), 0, 1e-12);
  EXPECT_NEAR(surface.calcVertexSlope(0, Vec3(1, 1, 1).normalized()), 1 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(surface.calcVertexSlope(0, -Vec3::UnitZ()), -1, 1e-12);
}

TEST(MovingSurface, FollowsNodesAndPoses) {
  Random random(1);
  const TriangleMesh fork = makeFork(Vec3(3, 1, 2));
  const CollisionSurface topology(fork.triangles);
  MovingSurface by_nodes(topology, fork.vertices), by_pose(topology, fork.vertices);
  const Pose pose = random.pose(1);
  by_nodes.update(calcMoved(fork.vertices, pose));
  by_pose.updateRigid(pose);
  for (int v = 0; v < topology.vertices(); ++v) {
    EXPECT_LT((by_nodes.position(v) - by_pose.position(v)).norm(), 1e-14);
    EXPECT_EQ(by_nodes.rest(v), fork.vertices[topology.node(v)]);
  }
  Vec3 weights;
  const Vec3 centre = (by_pose.corner(0, 0) + by_pose.corner(0, 1) + by_pose.corner(0, 2)) / 3;
  ASSERT_TRUE(by_pose.projectsInto(0, centre + by_pose.faceNormal(0), &weights));
  EXPECT_LT((weights - Vec3::Constant(1.0 / 3)).norm(), 1e-12);
  EXPECT_FALSE(by_pose.projectsInto(0, 2 * by_pose.corner(0, 1) - centre, &weights));
}

TEST(MovingSurface, RefusesNodesThatDoNotExist) {
  const TriangleMesh box = makeBar(Vec3(1, 1, 1), 1, 1, 1);
  EXPECT_THROW(MovingSurface(CollisionSurface(box.triangles), {Vec3::Zero()}), ConfigError);
}

}  // namespace
}  // namespace sinew
