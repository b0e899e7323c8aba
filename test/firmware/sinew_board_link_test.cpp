#include <gtest/gtest.h>
#include <sinew_board_link.h>

#include "firmware/board_bench.h"
#include "pressure_examples.h"

namespace sinew {
namespace {

using Bytes = PressureExample::Bytes;

struct LinkBench : BoardBench {
  LinkBench() {
    sinew_serial_start(&serial, &board, 5);
    sinew_can_start(&can, &board, 5);
  }

  Bytes send(const Bytes& bytes) {
    Bytes all;
    std::uint8_t answer[SINEW_MAX_FRAME];
    for (const std::uint8_t b : bytes) {
      const std::size_t size = sinew_serial_take(&serial, b, answer);
      all.insert(all.end(), answer, answer + size);
    }
    return all;
  }

  std::vector<sinew_can_frame> send(const PressureExample::Can& frame) {
    sinew_can_frame in{};
    in.id = frame.id;
    in.size = static_cast<std::uint8_t>(frame.data.size());
    std::copy(frame.data.begin(), frame.data.end(), in.data);
    std::vector<sinew_can_frame> out(SINEW_MAX_CAN_FRAMES);
    out.resize(sinew_can_take(&can, &in, out.data()));
    return out;
  }

  sinew_serial_link serial{};
  sinew_can_link can{};
  std::map<std::string, PressureExample> examples = PressureExample::load();
};

TEST(SinewBoardLink, AnswersTheDocumentsConfigureWithItsConfiguration) {
  LinkBench b;
  EXPECT_EQ(b.send(b.examples.at("CONFIGURE").frame), b.examples.at("CONFIGURATION").frame);
  EXPECT_TRUE(b.board.armed);
}

TEST(SinewBoardLink, SkipsNoiseForeignAndOverlongFrames) {
  LinkBench b;
  const Bytes hello = b.examples.at("HELLO").frame;
  EXPECT_TRUE(b.send(Bytes(1000, 7)).empty());
  EXPECT_TRUE(b.send(Bytes{0, 0, 3, 1}).empty());
  EXPECT_TRUE(b.send(Bytes{0}).empty());
  EXPECT_FALSE(b.send(hello).empty());
  EXPECT_TRUE(b.send(b.examples.at("IDENTITY").frame).empty()) << "its own answer, echoed";
  b.serial.address = 6;
  EXPECT_TRUE(b.send(hello).empty());
}

TEST(SinewBoardLink, CanConfiguresOnlyWhenAllPartsHaveCome) {
  LinkBench b;
  const auto& frames = b.examples.at("CONFIGURE").can;
  EXPECT_TRUE(b.send(frames[1]).empty());
  const auto error = b.send(frames[2]);
  ASSERT_EQ(error.size(), 1u);
  EXPECT_EQ(error[0].data[1], SINEW_WRONG_COUNT);
  EXPECT_FALSE(b.board.armed);
  b.send(frames[0]);
  b.send(frames[1]);
  const auto answer = b.send(frames[2]);
  ASSERT_EQ(answer.size(), 3u);
  EXPECT_TRUE(b.board.armed);
  EXPECT_EQ(b.board.channels[1].configuration.on_timeout, SINEW_SEAL);
  const auto& expected = b.examples.at("CONFIGURATION").can;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(answer[i].id, expected[i].id);
    EXPECT_TRUE(std::equal(expected[i].data.begin(), expected[i].data.end(), answer[i].data));
  }
}

TEST(SinewBoardLink, CanSetPointsUseTheBoundsAndTellTheirRefusalWithTheState) {
  LinkBench b;
  for (const auto& frame : b.examples.at("CONFIGURE").can) b.send(frame);
  for (const auto& frame : b.examples.at("SET_POINTS").can) EXPECT_TRUE(b.send(frame).empty());
  EXPECT_EQ(b.mode(0), SINEW_REGULATE);
  EXPECT_EQ(b.mode(1), SINEW_SEAL);
  EXPECT_EQ(b.board.channels[0].set_point.limit, 60000) << "the configuration's";
  b.send(b.examples.at("SET_POINTS").can[0]);  // a replay
  auto state = b.send(b.examples.at("READ_STATE").can[0]);
  ASSERT_EQ(state.size(), 4u);
  EXPECT_EQ(state[3].data[5], SINEW_STALE);
  EXPECT_EQ(state[3].data[6] | state[3].data[7] << 8, 256) << "the sequence asked with";
  state = b.send(b.examples.at("READ_STATE").can[0]);
  EXPECT_EQ(state[3].data[5], SINEW_ACCEPTED) << "told once";
}

TEST(SinewBoardLink, CanFramesOfChannelsThatDoNotExistAreRefused) {
  LinkBench b;
  auto frame = b.examples.at("SET_POINTS").can[0];
  frame.id += 7;
  EXPECT_TRUE(b.send(frame).empty());
  EXPECT_EQ(b.send(b.examples.at("READ_STATE").can[0])[3].data[5], SINEW_WRONG_COUNT);
}

}  // namespace
}  // namespace sinew
