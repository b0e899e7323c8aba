#include "sinew/robot/region_description.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(RegionDescription, HoldsItsShapesWithTheirBorders) {
  RegionDescription region;
  EXPECT_FALSE(region.contains(Vec3::Zero()));
  region.boxes = {{Vec3(0, 0, 0), Vec3(1, 2, 3)}, {Vec3(5, 5, 5), Vec3(6, 6, 6)}};
  region.spheres = {{Vec3(-1, 0, 0), 0.5}};
  for (const Vec3& inside : {Vec3(0, 0, 0), Vec3(1, 2, 3), Vec3(0.5, 1, 2), Vec3(5.5, 5, 6), Vec3(-1.5, 0, 0)}) {
    EXPECT_TRUE(region.contains(inside)) << inside.transpose();
  }
  for (const Vec3& outside : {Vec3(1.01, 1, 1), Vec3(0.5, 1, -0.01), Vec3(3, 3, 4), Vec3(-1.4, 0.4, 0)}) {
    EXPECT_FALSE(region.contains(outside)) << outside.transpose();
  }
}

}  // namespace
}  // namespace sinew
