#include "sinew/inverse/overload_ladder.h"

#include <gtest/gtest.h>

#include <random>

namespace sinew {
namespace {

using Level = OverloadLevel;

constexpr double kPeriod = 0.001;  // s
constexpr int kLong = 100000;      // cycles

OverloadLadder::Settings makeSettings() {
  OverloadLadder::Settings settings;
  settings.above = 0.85;
  settings.below = 0.6;
  settings.recovery = 0.05;
  return settings;
}

class LadderTest : public testing::Test {
 protected:
  OverloadLadder ladder{makeSettings()};

  Level feed(double share, int cycles = 1, double spared = 0) {
    for (int k = 0; k < cycles; ++k) ladder.update({share * kPeriod, spared * kPeriod}, kPeriod);
    return ladder.level();
  }

  void comeDown() { ASSERT_EQ(feed(0.1, kLong), Level::kNone); }

  int countCyclesUntil(Level level, double share) {
    int cycles = 0;
    for (; ladder.level() != level && cycles < kLong; ++cycles) feed(share);
    return cycles;
  }
};

TEST_F(LadderTest, startsAtTheTop) {
  EXPECT_EQ(ladder.level(), Level::kSharedLinearisation);
}

TEST_F(LadderTest, comesDownOneLevelAtATimeAfterTheRecoveryTime) {
  const int wait = 50;  // cycles of the recovery time
  for (const Level level : {Level::kNoExploration, Level::kOneNewtonStep, Level::kNone}) {
    EXPECT_NEAR(countCyclesUntil(level, 0.5), wait, 1.5);
  }
  EXPECT_EQ(feed(0.5, kLong), Level::kNone);
}

TEST_F(LadderTest, climbsInOrder) {
  comeDown();
  EXPECT_EQ(feed(0.9, 2), Level::kOneNewtonStep);
  EXPECT_EQ(feed(0.9, 2), Level::kNoExploration);
  EXPECT_EQ(feed(0.9, 2), Level::kSharedLinearisation);
  EXPECT_EQ(feed(0.9, 20), Level::kSharedLinearisation);
}

TEST_F(LadderTest, oneLongCycleAloneChangesNothing) {
  comeDown();
  for (int k = 0; k < 1000; ++k) {
    ASSERT_EQ(feed(20), Level::kNone);
    ASSERT_EQ(feed(0.84), Level::kNone);
  }
}

TEST_F(LadderTest, goesToTheTopAtOnceWherePeriodsAreOutlasted) {
  comeDown();
  EXPECT_EQ(feed(1.1), Level::kNone);
  EXPECT_EQ(feed(1.1), Level::kSharedLinearisation);
  comeDown();
  feed(0.9);
  EXPECT_EQ(feed(1.1), Level::kOneNewtonStep) << "only one of the two missed its deadline";
}

TEST_F(LadderTest, staysBetweenTheThresholds) {
  comeDown();
  EXPECT_EQ(feed(0.9, 2), Level::kOneNewtonStep);
  EXPECT_EQ(feed(0.7, kLong), Level::kOneNewtonStep);
  EXPECT_EQ(feed(0.5, kLong), Level::kNone);
}

TEST_F(LadderTest, oneCycleTooLongBeginsTheWaitAnew) {
  for (int k = 0; k < 100; ++k) {
    ASSERT_EQ(feed(0.5, 40), Level::kSharedLinearisation);
    ASSERT_EQ(feed(0.65), Level::kSharedLinearisation);
  }
}

TEST_F(LadderTest, whatIsSparedCounts) {
  EXPECT_EQ(feed(0.3, kLong, 0.4), Level::kSharedLinearisation);
  EXPECT_EQ(feed(0.3, kLong, 0.2), Level::kNone);
}

// A cycle that takes 0.3 of the period at a level and 2 at the one below, of which nobody could know.
TEST_F(LadderTest, hardlyFlapsBetweenTwoLevels) {
  int misses = 0;
  for (int k = 0; k < kLong; ++k) {
    const bool heavy = ladder.level() < Level::kNoExploration;
    misses += heavy;
    feed(heavy ? 2.0 : 0.3);
  }
  EXPECT_LE(misses, kLong / 500);
}

TEST_F(LadderTest, isAsQuickAsEverOnceALevelHasHeld) {
  for (int k = 0; k < kLong; ++k) feed(ladder.level() < Level::kNoExploration ? 2.0 : 0.3);
  comeDown();
  feed(0.9, 2);
  EXPECT_LE(countCyclesUntil(Level::kNone, 0.3), 101);
}

/// Above what the deadline allows it never takes more than two cycles to give way, whatever has been before.
TEST_F(LadderTest, givesWayInTwoCyclesFromAnywhere) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1.2);
  std::uniform_int_distribution<int> cycles(1, 400);
  for (int k = 0; k < 2000; ++k) {
    feed(share(random), cycles(random), share(random));
    ASSERT_EQ(feed(1.01, 3), Level::kSharedLinearisation);
  }
}

TEST_F(LadderTest, passesOverLevelsOfNoUse) {
  OverloadLadder::Settings settings = makeSettings();
  settings.useful = {{true, false, false, true}};
  ladder = OverloadLadder(settings);
  EXPECT_EQ(countCyclesUntil(Level::kNoExploration, 0.5), kLong) << "it never stands there";
  EXPECT_EQ(ladder.level(), Level::kNone);
  EXPECT_EQ(feed(0.86, 2), Level::kSharedLinearisation);
  settings.useful = {{true, false, true, true}};
  ladder = OverloadLadder(settings);
  comeDown();
  EXPECT_EQ(feed(0.86, 2), Level::kNoExploration);
  EXPECT_EQ(feed(0.86, 2), Level::kSharedLinearisation);
}

TEST_F(LadderTest, isDeterministic) {
  OverloadLadder other(makeSettings());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> time(0, 1.5 * kPeriod);
  for (int k = 0; k < 10000; ++k) {
    const CycleCost cost{time(random), time(random)};
    ASSERT_EQ(ladder.update(cost, kPeriod), other.update(cost, kPeriod));
  }
}

}  // namespace
}  // namespace sinew
