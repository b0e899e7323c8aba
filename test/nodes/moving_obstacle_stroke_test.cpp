#include <gtest/gtest.h>

#include "moving_obstacle_node_stroke.h"

namespace sinew {
namespace {

TEST(ObstacleStroke, GoesThereAndBackAtEvenSpeed) {
  ObstacleStroke stroke;
  stroke.amplitude = 0.02;
  stroke.speed = 0.04;
  stroke.dwell = 0.25;
  EXPECT_DOUBLE_EQ(1.5, stroke.calcPeriod());
  for (const double turn : {0.0, 1.5, 15.0}) {
    EXPECT_NEAR(0, stroke.calcDistance(turn), 1e-12);
    EXPECT_NEAR(0.01, stroke.calcDistance(turn + 0.25), 1e-12);
    EXPECT_NEAR(0.02, stroke.calcDistance(turn + 0.6), 1e-12);
    EXPECT_NEAR(0.01, stroke.calcDistance(turn + 1.0), 1e-12);
    EXPECT_NEAR(0, stroke.calcDistance(turn + 1.4), 1e-12);
  }
  EXPECT_EQ(0, stroke.calcDistance(-1));
}

TEST(ObstacleStroke, EndsWhereItBegan) {
  ObstacleStroke stroke;
  stroke.turns = 2;
  const double middle = stroke.calcPeriod() + stroke.amplitude / stroke.speed + 0.5 * stroke.dwell;
  EXPECT_EQ(stroke.amplitude, stroke.calcDistance(middle));
  EXPECT_EQ(0, stroke.calcDistance(middle + stroke.calcPeriod()));
}

}  // namespace
}  // namespace sinew
