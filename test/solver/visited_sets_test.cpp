#include "sinew/solver/visited_sets.h"

#include <gtest/gtest.h>

#include <set>

namespace sinew {
namespace {

TEST(VisitedSets, takesEachSetOnce) {
  VisitedSets visited(8);
  std::set<std::uint64_t> reference;
  for (std::uint64_t k = 0; k < 150; ++k) {
    const std::uint64_t hash = k * k % 128 * 256;  // many in one slot
    EXPECT_EQ(visited.contains(hash), reference.count(hash) == 1);
    EXPECT_EQ(visited.insert(hash), reference.insert(hash).second);
  }
  visited.clear();
  EXPECT_FALSE(visited.contains(0));
  EXPECT_TRUE(visited.insert(0));
}

TEST(VisitedSets, takesNothingOnceFull) {
  VisitedSets visited(4);
  for (std::uint64_t k = 0; k < 12; ++k) EXPECT_TRUE(visited.insert(k));
  EXPECT_TRUE(visited.full());
  EXPECT_FALSE(visited.insert(100));
  EXPECT_TRUE(visited.contains(7));
  visited.clear();
  EXPECT_TRUE(visited.insert(100));
}

}  // namespace
}  // namespace sinew
