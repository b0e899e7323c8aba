#include "sinew/hardware/slcan_codec.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "hardware/can_frames.h"

namespace sinew {
namespace {

std::string encode(const CanFrame& frame) {
  std::uint8_t out[kMaxSlcanLine];
  return std::string(reinterpret_cast<const char*>(out), encodeSlcan(frame, out));
}

std::vector<SlcanEvent> put(SlcanDecoder& decoder, const std::string& text) {
  std::vector<SlcanEvent> events;
  for (const char c : text) {
    const SlcanEvent event = decoder.put(static_cast<std::uint8_t>(c));
    if (event != SlcanEvent::kNone) events.push_back(event);
  }
  return events;
}

// LAWICEL, "CAN232 Manual", version 3.0, chapter of the ASCII commands, examples of t, T, r and R.
TEST(SlcanCodec, WritesTheExamplesOfTheManual) {
  EXPECT_EQ(encode(makeFrame(0x100, {0x11, 0x33})), "t10021133\r");
  EXPECT_EQ(encode(makeExtended(0x100, {0x11, 0x33})), "T0000010021133\r");
  EXPECT_EQ(encode(makeRemote(0x100, 2)), "r1002\r");
  CanFrame extended_remote = makeExtended(0x100, {});
  extended_remote.remote = true;
  extended_remote.size = 2;
  EXPECT_EQ(encode(extended_remote), "R000001002\r");
}

// Linux kernel, drivers/net/can/slcan, examples of the ASCII representation in the head of the file.
TEST(SlcanCodec, ReadsTheExamplesOfTheKernel) {
  SlcanDecoder decoder;
  const std::pair<const char*, CanFrame> cases[] = {{"t1230\r", makeFrame(0x123, {})},
                                                    {"t4563112233\r", makeFrame(0x456, {0x11, 0x22, 0x33})},
                                                    {"T12ABCDEF2AA55\r", makeExtended(0x12ABCDEF, {0xAA, 0x55})},
                                                    {"r1230\r", makeRemote(0x123, 0)}};
  for (const auto& c : cases) {
    ASSERT_EQ(put(decoder, c.first), std::vector<SlcanEvent>{SlcanEvent::kFrame}) << c.first;
    EXPECT_TRUE(decoder.frame() == c.second) << c.first;
    EXPECT_EQ(encode(c.second), c.first);
  }
}

TEST(SlcanCodec, LeavesTimeStampsAlone) {
  SlcanDecoder decoder;
  ASSERT_EQ(put(decoder, "t100211335D7A\r"), std::vector<SlcanEvent>{SlcanEvent::kFrame});
  EXPECT_TRUE(decoder.frame() == makeFrame(0x100, {0x11, 0x33}));
}

TEST(SlcanCodec, TellsAnswersApart) {
  SlcanDecoder decoder;
  using E = SlcanEvent;
  EXPECT_EQ(put(decoder, "\r\az\rZ\rV1013\rNA123\rF00\r"),
            (std::vector<E>{E::kOk, E::kError, E::kOk, E::kOk, E::kInfo, E::kInfo, E::kInfo}));
}

TEST(SlcanCodec, RefusesWhatIsNoFrameAndGoesOnBehindIt) {
  for (const char* wrong :
       {"t", "t12", "t123", "t1239", "t1231", "t12311", "t1231112", "t8000", "t12G0", "t123x", "r1009", "T200000000",
        "T1234567", "t-120", "x", "t1231zz", "t12311122334", "R0000010", "+"}) {
    SlcanDecoder decoder;
    EXPECT_EQ(put(decoder, std::string(wrong) + "\r"), std::vector<SlcanEvent>{SlcanEvent::kDamaged}) << wrong;
    EXPECT_EQ(put(decoder, "t4563112233\r"), std::vector<SlcanEvent>{SlcanEvent::kFrame}) << wrong;
  }
  SlcanDecoder decoder;
  EXPECT_EQ(put(decoder, "t123" + std::string(1000, '8') + "\r"), std::vector<SlcanEvent>{SlcanEvent::kDamaged});
  EXPECT_EQ(put(decoder, std::string(1000, 't') + "\at1230\r"),
            (std::vector<SlcanEvent>{SlcanEvent::kError, SlcanEvent::kFrame}));
}

TEST(SlcanCodec, EveryFrameComesBack) {
  std::mt19937 random(5);
  SlcanDecoder decoder;
  for (int n = 0; n < 20000; ++n) {
    const CanFrame frame = makeRandomFrame(random);
    ASSERT_EQ(put(decoder, encode(frame)), std::vector<SlcanEvent>{SlcanEvent::kFrame});
    ASSERT_TRUE(decoder.frame() == frame) << encode(frame);
  }
}

}  // namespace
}  // namespace sinew
