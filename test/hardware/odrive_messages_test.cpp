#include "sinew/hardware/odrive_messages.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "hardware/can_frames.h"
#include "sinew/hardware/actuator_reading.h"

namespace sinew {
namespace {

// ODrive documentation 0.5, "CAN Bus Guide for ODrive", verifying communication: candump of two axes, one of them in
// closed loop.
TEST(OdriveMessages, ReadsTheHeartbeatsOfTheGuide) {
  OdriveHeartbeat heartbeat;
  const CanFrame idle = makeFrame(0x001, {0, 0, 0, 0, 1, 0, 0, 0});
  ASSERT_TRUE(decodeOdrive(idle, heartbeat));
  EXPECT_EQ(odriveNode(idle), 0);
  EXPECT_EQ(odriveCommand(idle), OdriveCommand::kHeartbeat);
  EXPECT_EQ(heartbeat.state, static_cast<int>(OdriveState::kIdle));
  EXPECT_EQ(heartbeat.error, 0u);
  const CanFrame closed = makeFrame(0x021, {0, 0, 0, 0, 8, 0, 0, 0});
  ASSERT_TRUE(decodeOdrive(closed, heartbeat));
  EXPECT_EQ(odriveNode(closed), 1);
  EXPECT_EQ(heartbeat.state, static_cast<int>(OdriveState::kClosedLoop));
}

// odrive_can documentation, "Odrive cansimple interface": a heartbeat with error INVALID_STATE in state HOMING.
TEST(OdriveMessages, ReadsTheHeartbeatOfTheDatabase) {
  OdriveHeartbeat heartbeat;
  ASSERT_TRUE(decodeOdrive(makeFrame(0x001, {1, 0, 0, 0, 0x0B, 0, 0, 0}), heartbeat));
  EXPECT_EQ(heartbeat.error, 1u);
  EXPECT_EQ(heartbeat.state, 11);
}

// ODrive documentation, "CAN Protocol": the identifier of the example (axis 1, command 0C is 2C), start byte and type
// of every signal, little-endian, IEEE 754.
TEST(OdriveMessages, WritesWhatTheTableSays) {
  EXPECT_TRUE(makeOdriveInputPos(1, 1.0f) == makeFrame(0x2C, {0x00, 0x00, 0x80, 0x3F, 0, 0, 0, 0}));
  EXPECT_TRUE(makeOdriveInputPos(1, -2.5f) == makeFrame(0x2C, {0x00, 0x00, 0x20, 0xC0, 0, 0, 0, 0}));
  EXPECT_TRUE(makeOdriveAxisState(3, OdriveState::kClosedLoop) == makeFrame(0x67, {8, 0, 0, 0}));
  EXPECT_TRUE(makeOdrivePositionMode(3, OdriveInput::kPassThrough) == makeFrame(0x6B, {3, 0, 0, 0, 1, 0, 0, 0}));
  EXPECT_TRUE(makeOdrivePositionMode(3, OdriveInput::kTrapezoidal) == makeFrame(0x6B, {3, 0, 0, 0, 5, 0, 0, 0}));
  EXPECT_TRUE(makeOdriveLimits(0, 10.0f, 0.5f) == makeFrame(0x0F, {0, 0, 0x20, 0x41, 0, 0, 0, 0x3F}));
  EXPECT_TRUE(makeOdriveTrajVelLimit(0, 2.0f) == makeFrame(0x11, {0, 0, 0, 0x40}));
  EXPECT_TRUE(makeOdriveTrajAccelLimits(0, 2.0f) == makeFrame(0x12, {0, 0, 0, 0x40, 0, 0, 0, 0x40}));
  EXPECT_EQ(makeOdriveClearErrors(62).id, 62u * 32 + 0x18);
  EXPECT_TRUE(makeOdriveRequest(5, OdriveCommand::kGetEncoderEstimates) == makeRemote(0xA9, 0));
}

// ODrive documentation 0.6, "CAN Protocol", RxSdo and TxSdo: opcode (0 reads, 1 writes), endpoint, reserved, value.
TEST(OdriveMessages, ReadsAndWritesParameters) {
  EXPECT_TRUE(makeOdriveSdoWrite(2, {0x0123, 4, 0x3DCCCCCD}) ==
              makeFrame(0x44, {1, 0x23, 0x01, 0, 0xCD, 0xCC, 0xCC, 0x3D}));
  EXPECT_TRUE(makeOdriveSdoWrite(2, {0x0123, 1, 1}) == makeFrame(0x44, {1, 0x23, 0x01, 0, 1}));
  EXPECT_TRUE(makeOdriveSdoRead(2, 0x0123) == makeFrame(0x44, {0, 0x23, 0x01, 0}));
  OdriveSdo sdo;
  ASSERT_TRUE(decodeOdrive(makeFrame(0x45, {0, 0x23, 0x01, 0, 0xCD, 0xCC, 0xCC, 0x3D}), sdo));
  EXPECT_EQ(sdo.endpoint, 0x0123);
  EXPECT_EQ(sdo.value, 0x3DCCCCCDu);
  ASSERT_TRUE(decodeOdrive(makeFrame(0x45, {0, 0x23, 0x01, 0, 1}), sdo));
  EXPECT_EQ(sdo.size, 1);
  EXPECT_EQ(sdo.value, 1u);
  EXPECT_FALSE(decodeOdrive(makeFrame(0x45, {0, 0x23, 0x01, 0}), sdo));
}

TEST(OdriveMessages, ReadsPairsAndVersion) {
  OdrivePair pair;
  ASSERT_TRUE(decodeOdrive(makeFrame(0x29, {0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x20, 0xC0}), pair));
  EXPECT_EQ(pair.first, 1.0f);
  EXPECT_EQ(pair.second, -2.5f);
  OdriveVersion version;
  ASSERT_TRUE(decodeOdrive(makeFrame(0x20, {2, 4, 4, 58, 0, 6, 10, 0}), version));
  EXPECT_EQ(version.protocol, 2);
  EXPECT_EQ(version.minor, 6);
  EXPECT_EQ(version.revision, 10);
}

TEST(OdriveMessages, RefusesWhatIsNoNumberOrOfAnotherLength) {
  OdrivePair pair;
  OdriveHeartbeat heartbeat;
  for (const CanFrame& nonsense : {makeFrame(0x29, {0, 0, 0xC0, 0x7F, 0, 0, 0, 0}),  // not a number
                                   makeFrame(0x29, {0, 0, 0, 0, 0, 0, 0x80, 0x7F}),  // infinite
                                   makeFrame(0x29, {0, 0, 0, 0, 0, 0, 0}), makeRemote(0x29, 8)})
    EXPECT_FALSE(decodeOdrive(nonsense, pair));
  EXPECT_FALSE(decodeOdrive(makeFrame(0x21, {0, 0, 0, 0, 1, 0, 0}), heartbeat));
  EXPECT_FALSE(decodeOdrive(makeRemote(0x21, 8), heartbeat));
}

// ODrive documentation 0.6, API reference, ODrive.Error; and 0.5, ODrive.Axis.Error.
TEST(OdriveMessages, ErrorsBecomeFaults) {
  EXPECT_EQ(calcOdriveFaults(OdriveFirmware::k06, 0), 0u);
  EXPECT_EQ(calcOdriveFaults(OdriveFirmware::k06, 0x1000000), kFaultWatchdog);
  EXPECT_EQ(calcOdriveFaults(OdriveFirmware::k05, 0x800), kFaultWatchdog);
  EXPECT_EQ(calcOdriveFaults(OdriveFirmware::k06, 0x200 | 0x4000),
            kFaultVoltage | kFaultUndervolted | kFaultOverheated);
  EXPECT_EQ(calcOdriveFaults(OdriveFirmware::k05, 0x40000 | 0x100), kFaultOverheated | kFaultEncoder);
  for (int bit = 0; bit < 32; ++bit) {
    EXPECT_NE(calcOdriveFaults(OdriveFirmware::k06, 1u << bit), 0u) << bit;
    EXPECT_NE(calcOdriveFaults(OdriveFirmware::k05, 1u << bit), 0u) << bit;
  }
  EXPECT_EQ(describeOdriveError(OdriveFirmware::k06, 0x1000200),
            "0x01000200 (dc bus under voltage, watchdog timer expired)");
  EXPECT_EQ(describeOdriveError(OdriveFirmware::k06, 0x80), "0x00000080");
}

}  // namespace
}  // namespace sinew
