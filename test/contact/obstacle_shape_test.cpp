#include "sinew/contact/obstacle_shape.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "contact/shapes.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

std::vector<ObstacleShape> makeShapes() {
  return {ObstacleShape::makePlane(), ObstacleShape::makeSphere(0.02), ObstacleShape::makeBox(Vec3(0.01, 0.02, 0.03)),
          ObstacleShape::makeCylinder(0.02, 0.05), ObstacleShape::makeMesh(makeFork(Vec3(0.03, 0.02, 0.03)))};
}

TEST(ObstacleShape, NormalIsTheGradientOfTheDistanceAndThePointLiesOnTheShape) {
  Random random(1);
  for (const ObstacleShape& shape : makeShapes()) {
    int smooth = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 p = random.vector(0.05);
      const SurfaceDistance seen = shape.calcDistance(p);
      EXPECT_NEAR(seen.normal.norm(), 1, 1e-12);
      EXPECT_LT((seen.point + seen.distance * seen.normal - p).norm(), 1e-12);
      EXPECT_NEAR(shape.calcDistance(seen.point).distance, 0, 1e-12);
      Vec3 gradient;
      for (int k = 0; k < 3; ++k) {
        const Vec3 step = 1e-7 * Vec3::Unit(k);
        gradient[k] = (shape.calcDistance(p + step).distance - shape.calcDistance(p - step).distance) / 2e-7;
      }
      if ((gradient - seen.normal).norm() < 1e-4) ++smooth;
    }
    EXPECT_GT(smooth, 495) << "but for kinks inside";
  }
}

TEST(ObstacleShape, DistanceIsTheLeastToItsTriangles) {
  Random random(2);
  for (const ObstacleShape& shape : makeShapes()) {
    if (shape.kind() == ObstacleShape::Kind::kPlane) continue;
    const MeshDistance mesh(shape.makeTriangles(200).vertices, shape.makeTriangles(200).triangles);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = random.vector(0.05);
      EXPECT_NEAR(shape.calcDistance(p).distance, mesh.calcDistance(p).distance, 2e-5);
    }
  }
}

TEST(ObstacleShape, SignOfAConcaveMeshIsThatOfItsWinding) {
  Random random(3);
  const TriangleMesh fork = makeFork(Vec3(0.03, 0.02, 0.02));
  const ObstacleShape shape = ObstacleShape::makeMesh(fork);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p(random.uniform(-0.01, 0.04), random.uniform(-0.01, 0.03), random.uniform(-0.01, 0.03));
    const bool in_bar = p.minCoeff() > 0 && p.x() < 0.03 && p.y() < 0.02 && p.z() < 0.02;
    const bool in_gap = p.x() > 0.01 && p.x() < 0.02 && p.z() > 0.01;
    EXPECT_EQ(shape.calcDistance(p).distance < 0, in_bar && !in_gap);
  }
}

TEST(ObstacleShape, BoxHoldsTheShapeTightly) {
  Random random(4);
  for (const ObstacleShape& shape : makeShapes()) {
    if (shape.kind() == ObstacleShape::Kind::kPlane || shape.kind() == ObstacleShape::Kind::kMesh) continue;
    const TriangleMesh mesh = shape.makeTriangles(300);
    for (int i = 0; i < 20; ++i) {
      const Pose pose = random.pose(0.1);
      const Box box = shape.calcBox(pose);
      Box tight;
      for (const Vec3& x : mesh.vertices) tight.extend(pose * x);
      EXPECT_LT((box.lower - tight.lower).maxCoeff(), 1e-12);
      EXPECT_GT((box.upper - tight.upper).minCoeff(), -1e-12);
      EXPECT_LT((box.upper - tight.upper).maxCoeff(), 1e-5);
    }
  }
  const Box below = ObstacleShape::makePlane().calcBox(Pose::Identity());
  EXPECT_EQ(below.upper.z(), 0);
  EXPECT_GT(below.upper.x(), 1e3);
}

TEST(ObstacleShape, ChordEndsOnTheGrownShape) {
  Random random(5);
  for (const ObstacleShape& shape : {ObstacleShape::makePlane(), ObstacleShape::makeSphere(0.02)}) {
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = random.vector(0.03), d = random.direction();
      double enter, leave;
      if (!shape.calcChord(p, d, 1e-3, &enter, &leave)) {
        for (double t = -0.1; t < 0.1; t += 1e-3) EXPECT_GT(shape.calcDistance(p + t * d).distance, 1e-3);
        continue;
      }
      for (const double end : {enter, leave}) {
        const bool is_far = std::abs(end) > 1;
        EXPECT_TRUE(is_far || std::abs(shape.calcDistance(p + end * d).distance - 1e-3) < 1e-12) << end;
      }
    }
  }
  double enter, leave;
  const ObstacleShape cylinder = ObstacleShape::makeCylinder(0.01, 0.04);
  ASSERT_TRUE(cylinder.calcChord(Vec3(0.005, 0, 0), Vec3::UnitZ(), 1e-3, &enter, &leave));
  EXPECT_NEAR(leave, 0.021, 1e-15);
  ASSERT_TRUE(cylinder.calcChord(Vec3(0, 0, 0.01), Vec3::UnitX(), 1e-3, &enter, &leave));
  EXPECT_NEAR(enter, -0.011, 1e-15);
  EXPECT_FALSE(cylinder.calcChord(Vec3(0, 0, 0.03), Vec3::UnitX(), 1e-3, &enter, &leave));
}

TEST(ObstacleShape, RefusesSizesThatAreNone) {
  EXPECT_THROW(ObstacleShape::makeSphere(0), ConfigError);
  EXPECT_THROW(ObstacleShape::makeBox(Vec3(1, -1, 1)), ConfigError);
  EXPECT_THROW(ObstacleShape::makeCylinder(1, std::nan("")), ConfigError);
  TriangleMesh inside_out = makeTetrahedron(1);
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_THROW(ObstacleShape::makeMesh(inside_out), ConfigError);
}

}  // namespace
}  // namespace sinew
