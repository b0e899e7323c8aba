#include "sinew/hardware/simulated_line.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(SimulatedLine, WaitingMovesItsClockToTheAnswerAndNoFurther) {
  SimulatedServoBus servos({1});
  SimulatedLine line(servos);
  std::vector<std::uint8_t> ping;
  appendPacket(1, Instruction::kPing, nullptr, 0, ping);
  const Time start = line.now();
  ASSERT_EQ(line.write(ping.data(), ping.size(), Duration{0}).count, ping.size());
  EXPECT_EQ(line.now(), start);
  std::uint8_t data[100];
  EXPECT_EQ(line.read(data, sizeof data, duration(1e-4)).status, StreamStatus::kTimeout);
  EXPECT_EQ(line.now(), start + duration(1e-4));
  EXPECT_EQ(line.read(data, sizeof data, std::chrono::seconds(1)).count, 14u);
  EXPECT_NEAR(seconds(line.now() - start), (10 + 14) * 1e-5 + 500e-6, 1e-7);
}

TEST(SimulatedLine, UnpluggedIsClosed) {
  SimulatedServoBus servos({1});
  SimulatedLine line(servos);
  line.setPlugged(false);
  std::uint8_t byte = 0;
  EXPECT_EQ(line.write(&byte, 1, Duration{0}).status, StreamStatus::kClosed);
  EXPECT_EQ(line.read(&byte, 1, Duration{0}).status, StreamStatus::kClosed);
  line.setPlugged(true);
  EXPECT_EQ(line.read(&byte, 1, Duration{0}).status, StreamStatus::kTimeout);
}

}  // namespace
}  // namespace sinew
