#include "sinew/hardware/command_queue.h"

#include <gtest/gtest.h>

#include <thread>

namespace sinew {
namespace {

Command make(std::uint32_t sequence) {
  Command c;
  c.sequence = sequence;
  c.value.fill(sequence);
  return c;
}

TEST(CommandQueue, KeepsOrderAndSaysWhenFull) {
  CommandQueue queue;
  Command c;
  EXPECT_FALSE(queue.pop(c));
  std::uint32_t pushed = 0;
  while (queue.push(make(pushed))) ++pushed;
  EXPECT_GE(pushed, 32u);
  for (std::uint32_t i = 0; i < pushed; ++i) {
    ASSERT_TRUE(queue.pop(c));
    EXPECT_EQ(c.sequence, i);
  }
  EXPECT_FALSE(queue.pop(c));
}

TEST(CommandQueue, NothingIsLostOrTornBetweenThreads) {
  constexpr std::uint32_t kCount = 20000;
  CommandQueue queue;
  std::thread writer([&] {
    for (std::uint32_t i = 0; i < kCount; ++i)
      while (!queue.push(make(i))) std::this_thread::yield();
  });
  Command c;
  std::uint32_t wrong = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    while (!queue.pop(c)) std::this_thread::yield();
    if (c.sequence != i || c.value.front() != i || c.value.back() != i) ++wrong;
  }
  writer.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace sinew
