#include "stage_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace sinew {
namespace {

TEST(StageStatistics, AgreesWithASortedWindow) {
  constexpr int kWindow = 37;
  StageStatistics statistics(2, kWindow);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> first, second;
  for (int cycle = 0; cycle < 150; ++cycle) {
    const double durations[2] = {uniform(random), 10 * uniform(random)};
    first.push_back(durations[0]);
    second.push_back(durations[1]);
    statistics.add(durations);
    statistics.update();
    for (int stage = 0; stage < 2; ++stage) {
      const std::vector<double>& all = stage == 0 ? first : second;
      std::vector<double> window(all.end() - std::min<std::ptrdiff_t>(kWindow, cycle + 1), all.end());
      std::sort(window.begin(), window.end());
      EXPECT_EQ(statistics.last(stage), all.back());
      EXPECT_EQ(statistics.median(stage), window[window.size() / 2]);
      EXPECT_EQ(statistics.maximum(stage), window.back());
    }
  }
}

}  // namespace
}  // namespace sinew
