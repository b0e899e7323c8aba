#include "sinew/hardware/simulated_pressure_node.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"
#include "sinew/hardware/pressure_message.h"

namespace sinew {
namespace {

TEST(SimulatedPressureNode, RefusesChannelsThatItDoesNotHave) {
  EXPECT_THROW(SimulatedPressureNode(3, {0, 4}), ConfigError);
  EXPECT_EQ(SimulatedPressureNode(3, {2, 0}).size(), 2);
}

TEST(SimulatedPressureNode, AnswersItsOwnFramesOnly) {
  SimulatedPressureNode node(3, {0});
  std::vector<CanFrame> request, answer;
  appendPressureFrames(3, {}, request);
  node.take(request[0], Time{}, answer);
  EXPECT_EQ(answer.size(), 6u) << "four channels, the board, the end";
  answer.clear();
  appendPressureFrames(4, {}, request);
  node.take(request[1], Time{}, answer);
  EXPECT_TRUE(answer.empty());
}

TEST(SimulatedPressureNode, ActuatorsAreTheChannelsNamed) {
  SimulatedPressureNode node(3, {2, 0});
  std::vector<CanFrame> frames, answer;
  PressureRequest r;
  r.type = PressureType::kConfigure;
  r.configuration.timeout = 1000;
  r.configuration.count = 4;
  for (auto& c : r.configuration.channels) c = {100000, 500000, PressureMode::kVent};
  appendPressureFrames(3, r, frames);
  r.type = PressureType::kSetPoints;
  r.count = 4;
  r.set_points[2] = {PressureMode::kRegulate, 30000, 100000, 500000};
  appendPressureFrames(3, r, frames);
  for (const CanFrame& f : frames) node.take(f, Time{}, answer);
  node.step(0.9);
  EXPECT_NEAR(node.pressure(0), 30000, 150);
  EXPECT_NEAR(node.pressure(1), 0, 1);
  EXPECT_TRUE(node.energised(0));
  EXPECT_FALSE(node.energised(1));
}

}  // namespace
}  // namespace sinew
