#include "sinew/contact/surface_snapshot.h"

#include <gtest/gtest.h>

#include <limits>

#include "contact/shapes.h"

namespace sinew {
namespace {

using Feature = SurfaceSnapshot::Feature;

MovingSurface makeMoving(const TriangleMesh& mesh) {
  return MovingSurface(CollisionSurface(mesh.triangles), mesh.vertices);
}

Pose makeTurn(double angle) {
  return Pose(Eigen::AngleAxisd(angle, Vec3(1, 2, -2) / 3));
}

TEST(SurfaceSnapshot, KnowsNoDirectionBeforeItIsTaken) {
  const MovingSurface surface = makeMoving(makeBall(0.02, 1));
  EXPECT_FALSE(SurfaceSnapshot(surface).keepsDirections(surface, 0.1));
}

TEST(SurfaceSnapshot, SeesATurnOfAnyNormal) {
  MovingSurface surface = makeMoving(makeBall(0.02, 1));
  SurfaceSnapshot snapshot(surface);
  snapshot.take(surface);
  surface.updateRigid(makeTurn(0.05));
  EXPECT_TRUE(snapshot.keepsDirections(surface, 0.051));
  EXPECT_FALSE(snapshot.keepsDirections(surface, 0.049));
  surface.updateRigid(makeTurn(3));
  EXPECT_FALSE(snapshot.keepsDirections(surface, 1.5));
}

TEST(SurfaceSnapshot, TakesWhatIsNotANumberForATurn) {
  const TriangleMesh ball = makeBall(0.02, 1);
  MovingSurface surface = makeMoving(ball);
  SurfaceSnapshot snapshot(surface);
  snapshot.take(surface);
  std::vector<Vec3> nodes = ball.vertices;
  nodes[5].y() = std::numeric_limits<double>::quiet_NaN();
  surface.update(nodes);
  EXPECT_FALSE(snapshot.keepsDirections(surface, 1.5));
}

TEST(SurfaceSnapshot, PartsCoverTheSurfaceAndHoldItsMotion) {
  Random random(1);
  const TriangleMesh bar = makeBar(Vec3(0.06, 0.02, 0.02), 9, 3, 3);
  MovingSurface surface = makeMoving(bar);
  SurfaceSnapshot snapshot(surface);
  snapshot.take(surface);
  std::vector<Vec3> nodes = bar.vertices;
  for (Vec3& x : nodes) x += random.vector(1e-3);
  surface.update(nodes);
  snapshot.updateMotion(surface);
  ASSERT_GT(snapshot.parts(), 1);
  for (std::size_t t = 0; t < surface.topology().triangles().size(); ++t) {
    int holders = 0;
    for (int part = 0; part < snapshot.parts(); ++part) {
      bool holds = true;
      for (const int v : surface.topology().triangles()[t]) {
        const Vec3 way = surface.position(v) - snapshot.position(v);
        holds = holds && snapshot.place(part).overlaps({snapshot.position(v), snapshot.position(v)}) &&
                snapshot.motion(part).overlaps({way, way});
      }
      holders += holds ? 1 : 0;
    }
    EXPECT_GE(holders, 1);
  }
}

TEST(SurfaceSnapshot, HoldsTheFeaturesAsTheyWere) {
  const TriangleMesh ball = makeBall(0.02, 1);
  MovingSurface surface = makeMoving(ball);
  SurfaceSnapshot snapshot(surface);
  snapshot.take(surface);
  for (std::size_t t = 0; t < ball.triangles.size(); ++t) {
    const int triangle = static_cast<int>(t);
    Box expected;
    for (int i = 0; i < 3; ++i) expected.extend(surface.corner(triangle, i));
    const PackedBox& box = snapshot.box(Feature::kFace, triangle);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(box.lower[axis], expected.lower[axis], 1e-7);
      EXPECT_NEAR(box.upper[axis], expected.upper[axis], 1e-7);
    }
    EXPECT_EQ(snapshot.direction(Feature::kFace, triangle), surface.faceNormal(triangle));
  }
  EXPECT_NEAR(snapshot.direction(Feature::kEdge, 7).norm(), 1, 1e-12);
  EXPECT_NEAR(snapshot.direction(Feature::kVertex, 7).dot(surface.position(7).normalized()), 1, 1e-3);
}

}  // namespace
}  // namespace sinew
