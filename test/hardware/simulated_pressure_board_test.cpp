#include "sinew/hardware/simulated_pressure_board.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"
#include "sinew/hardware/cobs.h"
#include "sinew/hardware/pressure_message.h"

namespace sinew {
namespace {

/// A master that speaks the driver's side of the protocol.
struct Master {
  explicit Master(SimulatedPressureBoard& those) : board(those) {}

  PressureAnswer ask(PressureRequest request) {
    request.sequence = ++sequence;
    std::vector<std::uint8_t> bytes, packet;
    std::vector<std::vector<std::uint8_t>> frames;
    appendPressureRequest(static_cast<std::uint8_t>(board.address()), request, bytes);
    board.take(bytes.data(), bytes.size(), frames);
    PressureAnswer answer;
    answered = frames.size() == 1 && decodeCobs(frames[0].data(), frames[0].size() - 1, packet) &&
               decodePressureAnswer(packet.data(), packet.size(), answer);
    return answer;
  }
  PressureState read() { return ask({}).state; }

  void configure() {
    PressureRequest r;
    r.type = PressureType::kConfigure;
    r.configuration.timeout = 200;
    r.configuration.count = static_cast<std::uint8_t>(board.size());
    for (auto& c : r.configuration.channels) c = {100000, 500000, PressureMode::kVent};
    EXPECT_EQ(ask(r).type, PressureType::kConfiguration);
  }

  PressureReason regulate(std::int32_t pressure, int ms) {
    PressureRequest r;
    r.type = PressureType::kSetPoints;
    r.count = static_cast<std::uint8_t>(board.size());
    for (auto& s : r.set_points) s = {PressureMode::kRegulate, pressure, 100000, 500000};
    PressureReason refusal = PressureReason::kAccepted;
    for (int n = 0; n < ms; n += 20) {
      refusal = ask(r).state.refusal;
      board.step(0.02);
    }
    return refusal;
  }

  SimulatedPressureBoard& board;
  std::uint16_t sequence = 0;
  bool answered = false;
};

TEST(SimulatedPressureBoard, RefusesImpossibleBoards) {
  EXPECT_THROW(SimulatedPressureBoard(0), ConfigError);
  EXPECT_THROW(SimulatedPressureBoard(248), ConfigError);
  SimulatedPressureBoard::Parameters p;
  p.channels = 9;
  EXPECT_THROW(SimulatedPressureBoard(1, p), ConfigError);
}

TEST(SimulatedPressureBoard, RegulatesItsChambers) {
  SimulatedPressureBoard board(7);
  Master m(board);
  m.configure();
  EXPECT_FALSE(board.energised(0));
  EXPECT_EQ(m.regulate(60000, 3000), PressureReason::kAccepted);
  for (int i = 0; i < board.size(); ++i) {
    EXPECT_TRUE(board.energised(i));
    EXPECT_NEAR(board.pressure(i), 60000, 150);
  }
  EXPECT_EQ(m.read().channels[1].faults, 0);
  m.regulate(-30000, 3000);
  EXPECT_NEAR(board.pressure(2), -30000, 150);
}

TEST(SimulatedPressureBoard, HoldsItsSetPointAgainstALeakAndALoad) {
  SimulatedPressureBoard board(7);
  Master m(board);
  m.configure();
  m.regulate(60000, 2000);
  board.setLeak(0, 0.5);
  board.chamber(1).setVolume(0.8 * board.chamber(1).volume());
  EXPECT_GT(board.pressure(1), 90000);
  m.regulate(60000, 2000);
  EXPECT_NEAR(board.pressure(0), 60000, 500);
  EXPECT_NEAR(board.pressure(1), 60000, 150);
}

TEST(SimulatedPressureBoard, FrozenItNeitherAnswersNorMoves) {
  SimulatedPressureBoard board(7);
  Master m(board);
  m.configure();
  m.regulate(60000, 2000);
  board.setFrozen(true);
  const double before = board.pressure(0);
  board.step(1);
  EXPECT_EQ(board.pressure(0), before);
  m.read();
  EXPECT_FALSE(m.answered);
}

TEST(SimulatedPressureBoard, WithoutSupplyItsValvesFallOpenAndItRestartsUnarmed) {
  SimulatedPressureBoard board(7);
  Master m(board);
  m.configure();
  m.regulate(60000, 2000);
  EXPECT_EQ(m.read().uptime, 2000u);
  board.setSupplyVoltage(5);
  m.read();
  EXPECT_FALSE(m.answered);
  EXPECT_FALSE(board.energised(0));
  board.step(2);
  EXPECT_LT(board.pressure(0), 10);
  board.setSupplyVoltage(12);
  const PressureState state = m.read();
  EXPECT_TRUE(m.answered);
  EXPECT_EQ(state.uptime, 0u);
  EXPECT_EQ(state.flags & kBoardArmed, 0);
  EXPECT_EQ(m.regulate(60000, 20), PressureReason::kNotArmed);
}

TEST(SimulatedPressureBoard, PumpRefillsItsTank) {
  SimulatedPressureBoard board(7);
  Master m(board);
  m.configure();
  board.setLeak(0, 5);
  int switched = 0;
  bool ran = false;
  for (int n = 0; n < 200; ++n) {
    m.regulate(60000, 100);
    const bool runs = (m.read().flags & kBoardPump) != 0;
    switched += runs != ran ? 1 : 0;
    ran = runs;
  }
  EXPECT_GE(switched, 4) << "on and off, twice";
  EXPECT_EQ(m.read().channels[0].faults, 0);
}

TEST(SimulatedPressureBoard, CanAnswersAsSerialDoes) {
  SimulatedPressureBoard board(7);
  PressureRequest hello;
  hello.type = PressureType::kHello;
  std::vector<CanFrame> out, in;
  appendPressureFrames(7, hello, out);
  board.take(out[0], in);
  PressureFrameReader reader(7);
  ASSERT_EQ(in.size(), 2u);
  reader.take(in[0]);
  ASSERT_EQ(reader.take(in[1]), PressureFrameReader::Progress::kWhole);
  const PressureIdentity by_can = reader.answer().identity, by_serial = Master(board).ask(hello).identity;
  EXPECT_EQ(by_can.serial_number, by_serial.serial_number);
  EXPECT_EQ(by_can.channels, 4);
  EXPECT_EQ(by_can.range_max, by_serial.range_max);
  out[0].extended = false;
  in.clear();
  board.take(out[0], in);
  EXPECT_TRUE(in.empty());
}

}  // namespace
}  // namespace sinew
