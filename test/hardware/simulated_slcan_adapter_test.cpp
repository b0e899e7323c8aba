#include "sinew/hardware/simulated_slcan_adapter.h"

#include <gtest/gtest.h>

#include <string>

#include "hardware/can_frames.h"
#include "hardware/memory_stream.h"

namespace sinew {
namespace {

struct Bench {
  // What the adapter answers to `commands`; frames that they send are appended to `frames`.
  std::string tell(const std::string& commands) {
    line.arrive(MemoryStream::Bytes(commands.begin(), commands.end()));
    CanFrame frame;
    while (adapter.receive(frame, Duration{0}) == StreamStatus::kOk) frames.push_back(frame);
    return written();
  }
  std::string written() {
    const MemoryStream::Bytes bytes = line.takeWritten();
    return std::string(bytes.begin(), bytes.end());
  }
  MemoryStream line;
  SimulatedSlcanAdapter adapter{line};
  std::vector<CanFrame> frames;
};

TEST(SimulatedSlcanAdapter, OpensOnlyAfterItsBitRateIsSet) {
  Bench b;
  EXPECT_EQ(b.tell("O\r"), "\a");
  EXPECT_EQ(b.tell("S9\r"), "\a");
  EXPECT_EQ(b.tell("C\r"), "\a") << "closed already";
  EXPECT_EQ(b.tell("S8\rO\r"), "\r\r");
  EXPECT_TRUE(b.adapter.isOpen());
  EXPECT_EQ(b.adapter.bitrateDigit(), 8);
  EXPECT_EQ(b.tell("S6\r"), "\a") << "not while it is open";
  EXPECT_EQ(b.tell("V\rN\rF\r"), "V1013\rNA123\rF00\r");
  EXPECT_EQ(b.tell("C\r"), "\r");
}

TEST(SimulatedSlcanAdapter, PassesFramesOnlyWhileItIsOpen) {
  Bench b;
  EXPECT_EQ(b.tell("t10021133\r"), "\a");
  b.adapter.send(makeFrame(0x123, {}), Duration{0});
  EXPECT_EQ(b.written(), "");
  b.tell("S6\rO\r");
  EXPECT_EQ(b.tell("t10021133\rT0000010021133\rr1002\r"), "z\rZ\rz\r");
  ASSERT_EQ(b.frames.size(), 3u);
  EXPECT_TRUE(b.frames[0] == makeFrame(0x100, {0x11, 0x33}));
  EXPECT_TRUE(b.frames[1] == makeExtended(0x100, {0x11, 0x33}));
  EXPECT_TRUE(b.frames[2] == makeRemote(0x100, 2));
  b.adapter.send(makeExtended(0x12ABCDEF, {0xAA, 0x55}), Duration{0});
  b.adapter.send(makeRemote(0x123, 0), Duration{0});
  EXPECT_EQ(b.written(), "T12ABCDEF2AA55\rr1230\r");
}

TEST(SimulatedSlcanAdapter, RefusesNonsense) {
  Bench b;
  b.tell("S6\rO\r");
  for (const char* wrong : {"t", "t1239\r", "t12G0\r", "t1231A\r", "x\r", "T200000000\r"}) {
    const std::string line = wrong;
    EXPECT_EQ(b.tell(line.back() == '\r' ? line : line + "\r"), "\a") << wrong;
  }
  EXPECT_EQ(b.tell("t" + std::string(100000, '0') + "\r"), "\a");
  EXPECT_TRUE(b.frames.empty());
}

}  // namespace
}  // namespace sinew
