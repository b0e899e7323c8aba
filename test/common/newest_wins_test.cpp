#include "sinew/common/newest_wins.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <thread>

namespace sinew {
namespace {

TEST(NewestWins, StartsWithItsInitialValueAndNothingNew) {
  NewestWins<int> slot(7);
  EXPECT_FALSE(slot.update());
  EXPECT_EQ(slot.front(), 7);
}

TEST(NewestWins, PassesOverWhatNobodyRead) {
  NewestWins<int> slot(0);
  for (int value = 1; value <= 5; ++value) slot.write(value);
  EXPECT_TRUE(slot.update());
  EXPECT_EQ(slot.front(), 5);
  EXPECT_FALSE(slot.update());
  EXPECT_EQ(slot.front(), 5);
}

TEST(NewestWins, ShowsNothingBeforeItIsPublished) {
  NewestWins<int> slot(0);
  slot.back() = 1;
  EXPECT_FALSE(slot.update());
  EXPECT_EQ(slot.front(), 0);
  slot.publish();
  EXPECT_TRUE(slot.update());
  EXPECT_EQ(slot.front(), 1);
}

// Every order of writes and reads against the plain rule; the writer never fills the slot that the reader holds.
TEST(NewestWins, AgreesWithTheRuleInAnyOrder) {
  std::mt19937 random(1);
  NewestWins<int> slot(0);
  int newest = 0, taken = 0;
  for (int step = 0; step < 100000; ++step) {
    if (random() % 2 == 0) {
      slot.write(++newest);
    } else {
      ASSERT_EQ(slot.update(), newest != taken);
      taken = newest;
    }
    ASSERT_EQ(slot.front(), taken);
    ASSERT_NE(&slot.back(), &slot.front());
  }
}

// A value long enough to be torn, were it written while it is read.
using Long = std::array<long, 64>;

Long makeLong(long number) {
  Long value;
  value.fill(number);
  return value;
}

TEST(NewestWins, NeitherTearsNorAgesNorLosesTheLastValueBetweenThreads) {
  constexpr long kLast = 50000;
  NewestWins<Long> slot(makeLong(0));
  std::thread writer([&slot] {
    for (long number = 1; number <= kLast; ++number) slot.write(makeLong(number));
  });
  long torn = 0, aged = 0, before = 0;
  while (before < kLast) {
    if (!slot.update()) {
      std::this_thread::yield();
      continue;
    }
    const Long& value = slot.front();
    if (value != makeLong(value[0])) ++torn;
    if (value[0] <= before) ++aged;
    before = value[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(aged, 0);
  EXPECT_FALSE(slot.update());
}

}  // namespace
}  // namespace sinew
