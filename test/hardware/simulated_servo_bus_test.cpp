#include "sinew/hardware/simulated_servo_bus.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"
#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/serial_port.h"
#include "sinew/hardware/simulated_line.h"

namespace sinew {
namespace {

namespace reg = servo_register;
using Bytes = std::vector<std::uint8_t>;

const Time kStart{std::chrono::seconds(10)};

Bytes makePacket(std::uint8_t id, Instruction instruction, const Bytes& parameters) {
  Bytes out;
  appendPacket(id, instruction, parameters.data(), parameters.size(), out);
  return out;
}

Bytes ask(SimulatedServoBus& bus, const Bytes& packet, Time at = kStart) {
  bus.receive(packet.data(), packet.size(), at);
  Bytes out(1000);
  out.resize(bus.transmit(out.data(), out.size(), at + std::chrono::seconds(1)));
  return out;
}

TEST(SimulatedServoBus, RefusesDoubleIds) {
  EXPECT_THROW(SimulatedServoBus({1, 1}), ConfigError);
  EXPECT_THROW(SimulatedServoBus({253}), ConfigError);
}

TEST(SimulatedServoBus, AnswersThePingOfTheManualLikeAW350) {
  SimulatedServoBus bus({1});
  // As the e-Manual's answer, with model 1020 and firmware 45 in place of 1030 and 38.
  EXPECT_EQ(ask(bus, {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4E}),
            makePacket(1, Instruction::kStatus, {0x00, 0xFC, 0x03, 0x2D}));
}

TEST(SimulatedServoBus, AnswersOnePacketPerDeviceInTheOrderAsked) {
  SimulatedServoBus bus({1, 2, 3});
  Bytes expected;
  for (const std::uint8_t id : Bytes{3, 1}) {
    const Bytes one = makePacket(id, Instruction::kStatus, {0, id});
    expected.insert(expected.end(), one.begin(), one.end());
  }
  EXPECT_EQ(ask(bus, makePacket(kBroadcastId, Instruction::kSyncRead, {7, 0, 1, 0, 3, 1})), expected);
}

TEST(SimulatedServoBus, JointAnswerIsOnePacket) {
  SimulatedServoBus bus({3, 7, 4});
  const Bytes answer =
      ask(bus, {0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x0A, 0x00, 0x8A, 0x84, 0x00, 0x04, 0x00, 0x03, 0x07, 0x04, 0x20, 0xF2});
  ASSERT_EQ(answer.size(), 32u);
  EXPECT_EQ(answer[5], 0x19);
  EXPECT_EQ(answer[9], 3);
  EXPECT_EQ(answer[17], 7);
  EXPECT_EQ(answer[25], 4);
  for (const std::size_t end : {14u, 22u, 30u}) {
    const std::uint16_t crc = calcCrc(answer.data(), end);
    EXPECT_EQ(answer[end] | answer[end + 1] << 8, crc);
  }
}

TEST(SimulatedServoBus, BroadcastWritesAreNotAnswered) {
  SimulatedServoBus bus({1, 2});
  EXPECT_TRUE(ask(bus, makePacket(kBroadcastId, Instruction::kWrite, {64, 0, 1})).empty());
  EXPECT_TRUE(bus.torqueEnabled(0));
  EXPECT_TRUE(bus.torqueEnabled(1));
}

TEST(SimulatedServoBus, TimeOnTheLine) {
  SimulatedServoBus bus({1}, 57600);
  const Bytes packet = makePacket(1, Instruction::kRead, {132, 0, 4, 0});  // 14 bytes, answered by 15
  bus.receive(packet.data(), packet.size(), kStart);
  const double expected = (14 + 15) * 10 / 57600. + 500e-6;
  EXPECT_NEAR(seconds(bus.nextDue() - kStart), expected, 1e-6);
  std::uint8_t data[100];
  EXPECT_EQ(bus.transmit(data, sizeof data, kStart + duration(expected - 1e-5)), 0u);
  EXPECT_EQ(bus.transmit(data, sizeof data, kStart + duration(expected + 1e-5)), 15u);
}

TEST(SimulatedServoBus, DamagedRequestsAreNotAnswered) {
  SimulatedServoBus bus({1});
  EXPECT_TRUE(ask(bus, {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4F}).empty());
}

TEST(SimulatedServoBus, AnyPacketFeedsEveryWatchdog) {
  SimulatedServoBus bus({1, 2});
  for (const Bytes& p : {Bytes{11, 0, 4}, Bytes{64, 0, 1}, Bytes{98, 0, 2}})
    ask(bus, makePacket(0xFE, Instruction::kWrite, p));
  for (int n = 0; n < 20; ++n) {
    bus.step(0.03);
    ask(bus, makePacket(1, Instruction::kPing, {}));
  }
  EXPECT_EQ(bus.servo(1).value(reg::kBusWatchdog), 2);
  bus.step(0.05);
  EXPECT_EQ(bus.servo(1).value(reg::kBusWatchdog), 0xFF);
}

TEST(SimulatedServoBus, FaultsComeAsOftenAsAskedAndAreCounted) {
  SimulatedServoBus bus({1});
  LineFaults faults;
  faults.corrupt = 0.1;
  faults.drop = 0.05;
  faults.delay = 0.2;
  bus.setLineFaults(faults);
  const Bytes ping = makePacket(1, Instruction::kPing, {});
  const Bytes good = makePacket(1, Instruction::kStatus, {0x00, 0xFC, 0x03, 0x2D});
  std::uint64_t damaged = 0, none = 0;
  for (int n = 0; n < 20000; ++n) {
    const Bytes answer = ask(bus, ping, kStart + n * std::chrono::seconds(2));
    none += answer.empty() ? 1 : 0;
    damaged += !answer.empty() && answer != good ? 1 : 0;
  }
  const LineFaultCounts counts = bus.lineFaultCounts();
  EXPECT_EQ(counts.corrupted, damaged);
  EXPECT_EQ(counts.dropped, none);
  EXPECT_EQ(counts.sent + counts.corrupted + counts.dropped + counts.delayed, 20000u);
  EXPECT_NEAR(static_cast<double>(counts.corrupted), 2000, 150);
  EXPECT_NEAR(static_cast<double>(counts.dropped), 1000, 110);
  EXPECT_NEAR(static_cast<double>(counts.delayed), 4000, 200);
}

TEST(SimulatedServoBus, ServesAPseudoTerminalFromItsThread) {
  PseudoTerminal terminal;
  SimulatedServoBus servos({1, 2, 3});
  servos.start(terminal);
  SerialPort port;
  ASSERT_TRUE(port.open(terminal.path(), 1000000)) << port.error();
  DynamixelBus bus(1000000, std::chrono::seconds(5));
  bus.attach(&port);
  std::vector<SyncAnswer> answers(3);
  ASSERT_EQ(bus.syncWrite(reg::kGoalPosition, {1, 2, 3}, {10, 20, 30}), BusStatus::kOk);
  for (int n = 0; n < 20; ++n) {
    ASSERT_EQ(bus.syncRead(reg::kGoalPosition.address, 4, {1, 2, 3}, answers), BusStatus::kOk);
    EXPECT_EQ(decodeRegister(answers[2].data.data(), 4), 30);
  }
  servos.stop();
}

}  // namespace
}  // namespace sinew
