#include "sinew/contact/depth_view.h"

#include <gtest/gtest.h>

#include "contact/shapes.h"

namespace sinew {
namespace {

/// A box around everything is seen as the surface itself.
TEST(DepthView, OfAConcaveBodyInABoxHasItsLayersAndVolumeAlongEveryAxis) {
  const TriangleMesh fork = makeFork(Vec3(3, 1, 2));
  const MovingSurface surface(CollisionSurface(fork.triangles), fork.vertices);
  for (const int axis : {0, 1, 2}) {
    DepthView view(axis, 48, 100000);
    ASSERT_TRUE(
        view.update(surface, ObstacleShape::makeBox(Vec3::Constant(10)), 0, Pose::Identity(), surface.tree().box()));
    double volume = 0;
    std::size_t most = 0;
    for (const DepthView::Segment& segment : view.segments()) {
      volume += view.pixelArea() * (segment.end - segment.begin);
      ASSERT_GE(segment.begin_layer, 0);
      ASSERT_GE(segment.end_layer, 0);
      EXPECT_TRUE(view.layer(segment.begin_layer).is_front);
      EXPECT_FALSE(view.layer(segment.end_layer).is_front);
      EXPECT_NEAR(view.layer(segment.begin_layer).weights.sum(), 1, 1e-12);
      EXPECT_EQ(&view.segments()[view.findSegment(view.calcMiddle(segment))], &segment);
    }
    for (int pixel = 0; pixel < 48 * 48; ++pixel) {
      most = std::max<std::size_t>(most, view.firstSegment(pixel + 1) - view.firstSegment(pixel));
    }
    EXPECT_NEAR(volume, 5, 1e-12) << "axis " << axis;
    EXPECT_EQ(most, axis == 0 ? 2u : 1u);
  }
}

/// Diagonals, edges and corners that fall on the middles of pixels must give neither gaps nor double layers.
TEST(DepthView, IsWatertightWherePixelsMeetEdgesAndCorners) {
  const TriangleMesh bar = makeBar(Vec3(1, 1, 1), 4, 4, 4);
  const MovingSurface surface(CollisionSurface(bar.triangles), bar.vertices);
  Box shifted = surface.tree().box();
  for (const int pixels : {4, 6, 10, 34}) {
    for (const double shift : {0.0, 0.125, 0.5}) {
      shifted.lower = Vec3::Constant(-shift);
      shifted.upper = Vec3::Constant(1 - shift);
      DepthView view(2, pixels, 100000);
      ASSERT_TRUE(view.update(surface, ObstacleShape::makeBox(Vec3::Constant(10)), 0, Pose::Identity(), shifted));
      for (const DepthView::Segment& segment : view.segments()) {
        EXPECT_EQ(segment.begin, 0);
        EXPECT_EQ(segment.end, 1);
      }
      for (int pixel = 0; pixel < pixels * pixels; ++pixel) {
        const double u = (pixel % pixels + 0.5) / pixels - shift, v = (pixel / pixels + 0.5) / pixels - shift;
        const int seen = view.firstSegment(pixel + 1) - view.firstSegment(pixel);
        const bool is_on_edge = u == 0 || v == 0;
        EXPECT_TRUE(is_on_edge || seen == (u > 0 && v > 0 ? 1 : 0)) << u << ' ' << v;
      }
    }
  }
}

TEST(DepthView, SaysWhenItsRoomIsUsedUp) {
  const TriangleMesh bar = makeBar(Vec3(1, 1, 1), 2, 2, 2);
  const MovingSurface surface(CollisionSurface(bar.triangles), bar.vertices);
  DepthView view(0, 16, 100);
  EXPECT_FALSE(
      view.update(surface, ObstacleShape::makeBox(Vec3::Constant(10)), 0, Pose::Identity(), surface.tree().box()));
}

}  // namespace
}  // namespace sinew
