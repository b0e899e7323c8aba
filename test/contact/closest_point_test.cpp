#include "sinew/contact/closest_point.h"

#include <gtest/gtest.h>

#include "contact/shapes.h"

namespace sinew {
namespace {

TEST(ClosestPoint, OfATriangleIsNearerThanAnyOfItsOtherPoints) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 a = random.vector(1), b = random.vector(1), c = random.vector(1), p = random.vector(2);
    const Vec3 w = calcClosestWeights(a, b, c, p);
    EXPECT_NEAR(w.sum(), 1, 1e-12);
    EXPECT_GE(w.minCoeff(), 0);
    const double distance = (w[0] * a + w[1] * b + w[2] * c - p).norm();
    for (int k = 0; k < 100; ++k) {
      double u = random.uniform(0, 1), v = random.uniform(0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      EXPECT_GE(((1 - u - v) * a + u * b + v * c - p).norm(), distance - 1e-12);
    }
  }
}

TEST(ClosestPoint, OfATriangleWithoutAreaIsOnItsEdges) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(2, 0, 0);
  const Vec3 w = calcClosestWeights(a, b, c, Vec3(1.5, 1, 0));
  EXPECT_LT((w[0] * a + w[1] * b + w[2] * c - Vec3(1.5, 0, 0)).norm(), 1e-12);
}

TEST(ClosestPoint, OfTwoLinesIsAtARightAngleToBoth) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    const Vec3 a0 = random.vector(1), a1 = random.vector(1), b0 = random.vector(1), b1 = random.vector(1);
    const LineMeeting meeting = calcLineMeeting(a0, a1, b0, b1);
    ASSERT_FALSE(meeting.is_parallel);
    const Vec3 across = a0 + meeting.s * (a1 - a0) - b0 - meeting.t * (b1 - b0);
    EXPECT_NEAR(across.dot(a1 - a0), 0, 1e-9);
    EXPECT_NEAR(across.dot(b1 - b0), 0, 1e-9);
    EXPECT_NEAR(std::abs(across.dot(meeting.across)), across.norm(), 1e-9);
  }
  EXPECT_TRUE(calcLineMeeting(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3(3, 1, 0)).is_parallel);
}

}  // namespace
}  // namespace sinew
