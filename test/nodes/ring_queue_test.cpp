#include "ring_queue.h"

#include <gtest/gtest.h>

#include <thread>

namespace sinew {
namespace {

TEST(RingQueue, givesBackInOrder) {
  RingQueue<int> queue(3, 0);
  EXPECT_EQ(queue.front(), nullptr);
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 3; ++i) {
      ASSERT_NE(queue.back(), nullptr);
      *queue.back() = 10 * round + i;
      queue.push();
    }
    EXPECT_EQ(queue.back(), nullptr) << "full";
    for (int i = 0; i < 3; ++i) {
      ASSERT_NE(queue.front(), nullptr);
      EXPECT_EQ(*queue.front(), 10 * round + i);
      queue.pop();
    }
    EXPECT_EQ(queue.front(), nullptr);
  }
}

TEST(RingQueue, slotsKeepWhatTheyHaveBeenGiven) {
  RingQueue<std::vector<int>> queue(2, std::vector<int>(100));
  for (int k = 0; k < 5; ++k) {
    EXPECT_GE(queue.back()->capacity(), 100U);
    queue.back()->resize(7);
    queue.push();
    queue.pop();
  }
}

TEST(RingQueue, losesNothingBetweenTwoThreads) {
  constexpr int kCount = 200000;
  RingQueue<int> queue(16, -1);
  std::thread writer([&queue] {
    for (int k = 0; k < kCount;) {
      if (int* const slot = queue.back()) {
        *slot = k++;
        queue.push();
      } else {
        std::this_thread::yield();
      }
    }
  });
  for (int k = 0; k < kCount;) {
    const int* const value = queue.front();
    if (value == nullptr) {
      std::this_thread::yield();
      continue;
    }
    EXPECT_EQ(*value, k++);
    queue.pop();
  }
  writer.join();
  EXPECT_EQ(queue.front(), nullptr);
}

}  // namespace
}  // namespace sinew
