#include "sinew/hardware/dynamixel_bus.h"

#include <gtest/gtest.h>

#include <random>

#include "hardware/check_line.h"
#include "hardware/memory_stream.h"
#include "sinew/hardware/simulated_line.h"

namespace sinew {
namespace {

namespace reg = servo_register;

const std::vector<std::uint8_t> kIds = {1, 2, 3, 4};

struct Bench {
  Bench() : servos(kIds), line(servos), bus(1000000, std::chrono::milliseconds(2)) {
    bus.attach(&line);
    for (const std::uint8_t id : kIds) bus.write(id, reg::kReturnDelay, 0);
  }
  SimulatedServoBus servos;
  SimulatedLine line;
  DynamixelBus bus;
};

TEST(DynamixelBus, SendsTheExamplesOfTheManual) {
  MemoryStream stream;
  DynamixelBus bus(1000000, std::chrono::milliseconds(1));
  bus.attach(&stream);
  bus.setFastSyncRead(false);
  std::vector<SyncAnswer> answers(2);
  EXPECT_EQ(bus.syncRead(132, 4, {1, 2}, answers), BusStatus::kMissing);
  EXPECT_EQ(stream.takeWritten(), (MemoryStream::Bytes{0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04,
                                                       0x00, 0x01, 0x02, 0xCE, 0xFA}));
  bus.syncWrite(reg::kGoalPosition, {1, 2}, {150, 170});
  EXPECT_EQ(stream.takeWritten(),
            (MemoryStream::Bytes{0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x11, 0x00, 0x83, 0x74, 0x00, 0x04, 0x00,
                                 0x01, 0x96, 0x00, 0x00, 0x00, 0x02, 0xAA, 0x00, 0x00, 0x00, 0x82, 0x87}));
}

TEST(DynamixelBus, UnderstandsTheJointAnswerOfTheManual) {
  MemoryStream stream;
  DynamixelBus bus(1000000, std::chrono::milliseconds(1));
  bus.attach(&stream);
  stream.answerNextWrite({0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x19, 0x00, 0x55, 0x00, 0x03, 0xA6,
                          0x00, 0x00, 0x00, 0x84, 0x08, 0x00, 0x07, 0x1F, 0x08, 0x00, 0x00,
                          0x16, 0xCA, 0x00, 0x04, 0xFF, 0x03, 0x00, 0x00, 0xD1, 0x9E});
  std::vector<SyncAnswer> answers(3);
  EXPECT_EQ(bus.syncRead(132, 4, {3, 7, 4}, answers), BusStatus::kOk);
  EXPECT_EQ(decodeRegister(answers[0].data.data(), 4), 166);
  EXPECT_EQ(decodeRegister(answers[1].data.data(), 4), 2079);
  EXPECT_EQ(decodeRegister(answers[2].data.data(), 4), 1023);
}

TEST(DynamixelBus, PingReadWrite) {
  Bench b;
  DynamixelBus::Identity identity;
  ASSERT_EQ(b.bus.ping(3, identity), BusStatus::kOk);
  EXPECT_EQ(identity.model, 1020);
  EXPECT_EQ(b.bus.write(3, reg::kGoalPosition, 777), BusStatus::kOk);
  std::int32_t value = 0;
  EXPECT_EQ(b.bus.read(3, reg::kGoalPosition, value), BusStatus::kOk);
  EXPECT_EQ(value, 777);
  EXPECT_EQ(b.bus.ping(9, identity), BusStatus::kMissing);
  EXPECT_EQ(b.bus.counters().missing, 1u);
}

TEST(DynamixelBus, TellsWhyADeviceRefuses) {
  Bench b;
  EXPECT_EQ(b.bus.write(1, reg::kPresentPosition, 1), BusStatus::kDeviceError);
  EXPECT_EQ(b.bus.lastError(), static_cast<int>(ServoError::kAccess));
  EXPECT_EQ(b.bus.counters().device_error, 1u);
}

TEST(DynamixelBus, SyncWriteAndBothKindsOfSyncRead) {
  Bench b;
  ASSERT_EQ(b.bus.syncWrite(reg::kProfileVelocity, kIds, {10, 20, 30, 40}), BusStatus::kOk);
  for (const bool fast : {true, false}) {
    b.bus.setFastSyncRead(fast);
    std::vector<SyncAnswer> answers(4);
    ASSERT_EQ(b.bus.syncRead(reg::kProfileVelocity.address, 4, kIds, answers), BusStatus::kOk);
    for (int i = 0; i < 4; ++i)
      EXPECT_EQ(decodeRegister(answers[static_cast<std::size_t>(i)].data.data(), 4), 10 * (i + 1)) << fast;
  }
}

TEST(DynamixelBus, FallsBackForGoodWhenDevicesDoNotKnowTheJointAnswer) {
  Bench b;
  b.servos.setFastSyncReadSupported(false);
  std::vector<SyncAnswer> answers(4);
  for (int n = 0; n < 3; ++n) EXPECT_EQ(b.bus.syncRead(132, 4, kIds, answers), BusStatus::kMissing);
  for (int n = 0; n < 200; ++n) ASSERT_EQ(b.bus.syncRead(132, 4, kIds, answers), BusStatus::kOk);
  EXPECT_FALSE(b.bus.usesFastSyncRead());
}

TEST(DynamixelBus, ASilentDeviceDoesNotHideTheOthersForLong) {
  Bench b;
  std::vector<SyncAnswer> answers(4);
  ASSERT_EQ(b.bus.syncRead(132, 4, kIds, answers), BusStatus::kOk);
  b.servos.setFrozen(1, true);
  for (int n = 0; n < 4; ++n) b.bus.syncRead(132, 4, kIds, answers);
  EXPECT_EQ(answers[0].status, BusStatus::kOk);
  EXPECT_EQ(answers[1].status, BusStatus::kMissing);
  EXPECT_EQ(answers[3].status, BusStatus::kOk);
  b.servos.setFrozen(1, false);
  for (int n = 0; n < 60; ++n) b.bus.syncRead(132, 4, kIds, answers);
  EXPECT_TRUE(b.bus.usesFastSyncRead()) << "jointly again";
}

TEST(DynamixelBus, TakesNoLongerThanItsTime) {
  Bench b;
  std::int32_t value = 0;
  const Time start = b.line.now();
  EXPECT_EQ(b.bus.read(77, reg::kGoalPosition, value), BusStatus::kMissing);
  EXPECT_LT(seconds(b.line.now() - start), 0.003);
}

TEST(DynamixelBus, LateAnswersAreFlushedAndCounted) {
  Bench b;
  LineFaults faults;
  faults.delay = 1;
  faults.delay_time = 0.01;
  b.servos.setLineFaults(faults);
  std::int32_t value = 0;
  EXPECT_EQ(b.bus.read(1, reg::kModelNumber, value), BusStatus::kMissing);
  b.servos.setLineFaults({});
  b.line.advanceTo(b.line.now() + std::chrono::milliseconds(20));
  EXPECT_EQ(b.bus.read(1, reg::kGoalCurrent, value), BusStatus::kOk);
  EXPECT_EQ(value, 1193) << "not the model number that came first";
  EXPECT_EQ(b.bus.counters().stale, 1u);
  EXPECT_EQ(b.bus.counters().missing, 1u);
}

TEST(DynamixelBus, AnswersOfAnotherDeviceOrLengthAreNotTaken) {
  MemoryStream stream;
  DynamixelBus bus(1000000, std::chrono::milliseconds(1));
  bus.attach(&stream);
  MemoryStream::Bytes answer;
  const std::uint8_t other_length[] = {0, 1, 2}, other_id[] = {0, 9, 9, 9, 9}, right[] = {0, 166, 0, 0, 0};
  appendPacket(1, Instruction::kStatus, other_length, 3, answer);
  appendPacket(2, Instruction::kStatus, other_id, 5, answer);
  appendPacket(1, Instruction::kRead, right, 5, answer);  // not a status packet
  appendPacket(1, Instruction::kStatus, right, 5, answer);
  stream.answerNextWrite(answer);
  std::int32_t value = 0;
  EXPECT_EQ(bus.read(1, reg::kPresentPosition, value), BusStatus::kOk);
  EXPECT_EQ(value, 166);
  EXPECT_EQ(bus.counters().stale, 3u);
}

TEST(DynamixelBus, ClosedLineIsToldApart) {
  Bench b;
  b.line.setPlugged(false);
  std::int32_t value = 0;
  EXPECT_EQ(b.bus.read(1, reg::kGoalPosition, value), BusStatus::kClosed);
  b.bus.attach(nullptr);
  EXPECT_EQ(b.bus.read(1, reg::kGoalPosition, value), BusStatus::kClosed);
}

// A million damaged bits, anywhere in the packet, its length included.
TEST(DynamixelBus, DamagedAnswersAreNeverTakenForAnotherValue) {
  Bench b;
  std::mt19937 random(11);
  LineFaults faults;
  faults.corrupt = 1;
  faults.seed = 5;
  b.servos.setLineFaults(faults);
  b.servos.setFastSyncReadSupported(false);
  b.bus.setFastSyncRead(false);
  std::uint64_t wrong = 0, reads = 0;
  std::vector<SyncAnswer> answers(4);
  for (int n = 0; n < 125000; ++n) {
    const double angle = 1e-3 * static_cast<double>(random() % 100000) - 50;
    for (int i = 0; i < 4; ++i) b.servos.setShaftAngle(i, angle);
    b.bus.syncRead(reg::kPresentPosition.address, 4, kIds, answers);
    for (const SyncAnswer& a : answers)
      if (a.status != BusStatus::kMissing) ++wrong;
    reads += 4;
  }
  checkAtMost("servo_bus_faults.damaged_accepted", static_cast<double>(wrong), 0, "1");
  EXPECT_EQ(b.servos.lineFaultCounts().corrupted, reads);
  EXPECT_EQ(b.bus.counters().missing + b.bus.counters().corrupted, reads);
}

}  // namespace
}  // namespace sinew
