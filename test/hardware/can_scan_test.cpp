#include "sinew/hardware/can_scan.h"

#include <gtest/gtest.h>

#include "hardware/can_frames.h"
#include "hardware/odrive_bench.h"

namespace sinew {
namespace {

constexpr Time kStart{std::chrono::seconds(1)};

// CiA 301, boot-up and heartbeat protocols: 700 + node, state 0, 4, 5 or 7F.
TEST(CanScan, FindsCanOpenDevices) {
  CanScan scan;
  scan.take(makeFrame(0x705, {0x00}), kStart);
  scan.take(makeFrame(0x705, {0x7F}), kStart + std::chrono::milliseconds(500));
  scan.take(makeFrame(0x701, {0x05}), kStart);
  scan.take(makeFrame(0x185, {1, 2, 3}), kStart);
  const std::vector<CanScan::Node> nodes = scan.nodes();
  ASSERT_EQ(nodes.size(), 2u);
  EXPECT_EQ(nodes[0].number, 1);
  EXPECT_EQ(nodes[0].state, 5);
  EXPECT_FALSE(nodes[0].booted);
  EXPECT_EQ(nodes[1].number, 5);
  EXPECT_EQ(nodes[1].state, 0x7F);
  EXPECT_TRUE(nodes[1].booted);
  EXPECT_EQ(nodes[1].heartbeats, 2u);
  EXPECT_NEAR(nodes[1].period, 0.5, 1e-9);
  EXPECT_TRUE(scan.unknown().empty());
  EXPECT_EQ(scan.frames(), 4u);
}

TEST(CanScan, FindsOdrives) {
  OdriveBench bench(3);
  CanScan scan;
  const Time end = bench.port->now() + std::chrono::milliseconds(450);
  CanFrame frame;
  while (bench.port->receive(frame, end - bench.port->now()) == StreamStatus::kOk) scan.take(frame, bench.port->now());
  const std::vector<CanScan::Node> nodes = scan.nodes();
  ASSERT_EQ(nodes.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(nodes[i].protocol, CanScan::Protocol::kOdrive);
    EXPECT_EQ(nodes[i].number, static_cast<int>(i) + 1);
    EXPECT_EQ(nodes[i].state, 1);
    EXPECT_NEAR(nodes[i].period, 0.1, 0.002);
  }
  EXPECT_TRUE(scan.unknown().empty());
}

TEST(CanScan, TellsTheTwoApartByLength) {
  CanScan scan;
  scan.take(makeFrame(0x701, {0x05}), kStart);                    // CANopen node 1
  scan.take(makeFrame(0x701, {0, 0, 0, 0, 8, 0, 0, 0}), kStart);  // ODrive node 56
  const std::vector<CanScan::Node> nodes = scan.nodes();
  ASSERT_EQ(nodes.size(), 2u);
  EXPECT_EQ(nodes[0].protocol, CanScan::Protocol::kCanOpen);
  EXPECT_EQ(nodes[1].protocol, CanScan::Protocol::kOdrive);
  EXPECT_EQ(nodes[1].number, 56);
}

TEST(CanScan, CountsWhatItDoesNotKnow) {
  CanScan scan;
  for (int n = 0; n < 3; ++n) scan.take(makeExtended(0x123456, {1, 2}), kStart);
  scan.take(makeFrame(0x123, {1}), kStart);
  scan.take(makeFrame(0x705, {0x33}), kStart);  // no state that there is
  scan.take(makeFrame(0x021, {0, 0, 0, 0, 77, 0, 0, 0}), kStart);
  scan.take(makeRemote(0x041, 8), kStart);
  EXPECT_TRUE(scan.nodes().empty());
  const std::vector<CanScan::Identifier> unknown = scan.unknown();
  ASSERT_EQ(unknown.size(), 5u);
  EXPECT_EQ(unknown.back().id, 0x123456u);
  EXPECT_TRUE(unknown.back().extended);
  EXPECT_EQ(unknown.back().frames, 3u);
  EXPECT_EQ(unknown.back().size, 2);
}

}  // namespace
}  // namespace sinew
