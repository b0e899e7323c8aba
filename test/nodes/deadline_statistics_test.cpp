#include "deadline_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace sinew {
namespace {

constexpr double kPeriod = 0.01;  // s

TEST(DeadlineStatistics, countsWhatEndedLateAndWhatWasLeftOut) {
  DeadlineStatistics statistics(kPeriod, 10);
  for (const double ended : {0.002, 0.01, 0.0101, 0.03, 0.004}) statistics.add(ended, 0, OverloadLevel::kNone);
  EXPECT_EQ(statistics.misses(), 2U);
  statistics.add(0.004, 3, OverloadLevel::kNone);
  statistics.add(0.004, 3, OverloadLevel::kNone);
  EXPECT_EQ(statistics.misses(), 5U);
  EXPECT_EQ(statistics.worst(), 0.03);
}

TEST(DeadlineStatistics, countsTheCyclesOfEachLevel) {
  DeadlineStatistics statistics(kPeriod, 10);
  for (int k = 0; k < 6; ++k) statistics.add(0, 0, static_cast<OverloadLevel>(k % 4));
  const std::array<std::uint64_t, kOverloadLevels> expected = {{2, 2, 1, 1}};
  EXPECT_EQ(statistics.levels(), expected);
}

TEST(DeadlineStatistics, agreesWithASortedWindow) {
  constexpr int kWindow = 250;
  std::mt19937 random(2);
  std::exponential_distribution<double> ended(1000);
  DeadlineStatistics statistics(kPeriod, kWindow);
  std::vector<double> all;
  for (int k = 0; k < 1000; ++k) {
    all.push_back(ended(random));
    statistics.add(all.back(), 0, OverloadLevel::kNone);
    if (k % 37 != 0) continue;
    statistics.update();
    std::vector<double> window(all.end() - std::min<std::ptrdiff_t>(kWindow, k + 1), all.end());
    std::sort(window.begin(), window.end());
    const auto above =
        static_cast<double>(window.end() - std::upper_bound(window.begin(), window.end(), statistics.recent()));
    EXPECT_LE(above, 0.01 * static_cast<double>(window.size()));
    EXPECT_TRUE(std::binary_search(window.begin(), window.end(), statistics.recent()));
    const auto below =
        static_cast<double>(std::lower_bound(window.begin(), window.end(), statistics.recent()) - window.begin());
    EXPECT_LT(below, 0.99 * static_cast<double>(window.size()));
  }
}

TEST(DeadlineStatistics, knowsNothingBeforeTheFirstCycle) {
  DeadlineStatistics statistics(kPeriod, 10);
  statistics.update();
  EXPECT_EQ(statistics.misses(), 0U);
  EXPECT_EQ(statistics.recent(), 0);
}

}  // namespace
}  // namespace sinew
