#include "check_timing.h"

#include <gtest/gtest.h>

#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr int kCycles = 30;

TEST(CheckTiming, stagesAreWithinTheCycle) {
  const CycleTiming timing = timeCycles(makeRobot(readShippedRobot("finger")), kCycles);
  ASSERT_EQ(timing.cycle.size(), static_cast<std::size_t>(kCycles));
  ASSERT_EQ(timing.sharedCycle.size(), static_cast<std::size_t>(kCycles));
  double sum = 0;
  for (const DurationSample& stage : timing.stages) {
    ASSERT_EQ(stage.size(), static_cast<std::size_t>(kCycles));
    EXPECT_GE(stage.calcQuantile(0.01), 0);
    sum += stage.calcMean();
  }
  EXPECT_LE(sum, timing.cycle.calcMean());
  EXPECT_GT(sum, 0.5 * timing.cycle.calcMean()) << "something large is not named";
  EXPECT_EQ(timing.held, 0);
  EXPECT_TRUE(timing.rests);
}

TEST(CheckTiming, obstaclesCount) {
  const CycleTiming finger = timeCycles(makeRobot(readShippedRobot("finger")), kCycles);
  EXPECT_GT(finger.contacts, 0);
  EXPECT_GT(finger.shareOf(CycleTiming::kDetection), 0);
  RobotDescription alone = readShippedRobot("finger");
  alone.obstacles.clear();
  alone.contacts.self = false;
  const CycleTiming timing = timeCycles(makeRobot(alone), kCycles);
  EXPECT_EQ(timing.contacts, 0);
}

TEST(CheckTiming, ratesLeaveAQuarterOfThePeriod) {
  CycleTiming timing;
  for (int k = 1; k <= 100; ++k) timing.cycle.add(1e-3 * k);
  timing.sharedCycle.add(1e-3);
  EXPECT_NEAR(timing.predictRate(), 0.75 / 0.099, 1e-9);
  EXPECT_NEAR(timing.predictSharedRate(), 750, 1e-9);
}

}  // namespace
}  // namespace sinew
