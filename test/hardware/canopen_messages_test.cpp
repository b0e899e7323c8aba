#include "sinew/hardware/canopen_messages.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace sinew::canopen {
namespace {

using Bytes = std::array<std::uint8_t, 8>;

CanFrame makeFrame(std::uint32_t id, const Bytes& data, std::uint8_t size = 8) {
  CanFrame frame;
  frame.id = id;
  frame.size = size;
  frame.data = data;
  return frame;
}

void expectFrame(const CanFrame& frame, std::uint32_t id, const Bytes& data, std::uint8_t size = 8) {
  EXPECT_EQ(frame.id, id);
  EXPECT_EQ(frame.size, size);
  EXPECT_EQ(frame.data, data);
  EXPECT_FALSE(frame.extended || frame.remote);
}

CanFrame download(std::uint8_t node, ObjectAddress object, std::uint32_t value, std::size_t size) {
  std::uint8_t data[4];
  storeNumber(value, size, data);
  return makeSdoDownload(node, object, data, size);
}

// Festo GDCP-CMMP-M3/-M0-C-CO, section 3.2.1 "SDO Sequences for Reading and Writing".
TEST(CanopenMessages, FestoReadsAndWrites) {
  expectFrame(makeSdoUpload(1, {0x6061, 0}), 0x601, {0x40, 0x61, 0x60, 0x00});
  expectFrame(download(1, {0x1401, 2}, 0xEF, 1), 0x601, {0x2F, 0x01, 0x14, 0x02, 0xEF});
  expectFrame(download(1, {0x6040, 0}, 0x03E8, 2), 0x601, {0x2B, 0x40, 0x60, 0x00, 0xE8, 0x03});
  expectFrame(download(1, {0x6093, 1}, 0x12345678, 4), 0x601, {0x23, 0x93, 0x60, 0x01, 0x78, 0x56, 0x34, 0x12});

  SdoReply reply;
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x4F, 0x61, 0x60, 0x00, 0x01}), 1, reply));
  EXPECT_EQ(reply.kind, SdoReply::Kind::kUpload);
  EXPECT_EQ(reply.size, 1u);
  EXPECT_EQ(reply.data[0], 1);
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x4B, 0x41, 0x60, 0x00, 0x34, 0x12}), 1, reply));
  EXPECT_EQ(reply.size, 2u);
  EXPECT_EQ(loadNumber(reply.data.data(), 2), 0x1234u);
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x43, 0x93, 0x60, 0x01, 0x78, 0x56, 0x34, 0x12}), 1, reply));
  EXPECT_EQ(reply.object, (ObjectAddress{0x6093, 1}));
  EXPECT_EQ(loadNumber(reply.data.data(), 4), 0x12345678u);
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x60, 0x40, 0x60, 0x00}), 1, reply));
  EXPECT_EQ(reply.kind, SdoReply::Kind::kDownload);
}

// Baumueller b maXX 1000 parameter manual 5.07004.03, "SDO", example: 5 to object 6060 of node 4.
TEST(CanopenMessages, BaumuellerWritesAMode) {
  expectFrame(download(4, {0x6060, 0}, 5, 1), 0x604, {0x2F, 0x60, 0x60, 0x00, 0x05});
  SdoReply reply;
  ASSERT_TRUE(readSdoReply(makeFrame(0x584, {0x60, 0x60, 0x60, 0x00}), 4, reply));
  EXPECT_EQ(reply.object, (ObjectAddress{0x6060, 0}));
}

// A trace of CODESYS, "CANopen Object 1016h: Consumer heartbeat time": node 2 watches node 127 for 300 ms.
TEST(CanopenMessages, ConsumerHeartbeat) {
  expectFrame(download(2, {0x1016, 1}, 127u << 16 | 300u, 4), 0x602, {0x23, 0x16, 0x10, 0x01, 0x2C, 0x01, 0x7F, 0x00});
}

// Faulhaber MC 5010 communications manual 7000.05050, table 10: following error.
TEST(CanopenMessages, FaulhaberEmergency) {
  Emergency emergency;
  ASSERT_TRUE(readEmergency(makeFrame(0x083, {0x11, 0x86, 0x20, 0x02}), 3, emergency));
  EXPECT_EQ(emergency.code, 0x8611);
  EXPECT_EQ(emergency.error_register, 0x20);
  EXPECT_EQ(emergency.vendor[0], 0x02);
  EXPECT_STREQ(describeEmergency(emergency.code), "following error");
}

// CiA 301, "NMT object control", "Heartbeat protocol", "SYNC": identifiers and bytes of the frames.
TEST(CanopenMessages, NetworkManagement) {
  expectFrame(makeNmt(NmtCommand::kStart, 5), 0x000, {0x01, 0x05}, 2);
  expectFrame(makeNmt(NmtCommand::kPreOperational, 9), 0x000, {0x80, 0x09}, 2);
  expectFrame(makeNmt(NmtCommand::kResetCommunication, 9), 0x000, {0x82, 0x09}, 2);
  expectFrame(makeSync(), 0x080, {}, 0);
  expectFrame(makeHeartbeat(0x7F, NmtState::kOperational), 0x77F, {0x05}, 1);
  NmtState state{};
  ASSERT_TRUE(readHeartbeat(makeFrame(0x705, {0x7F}, 1), 5, state));
  EXPECT_EQ(state, NmtState::kPreOperational);
  ASSERT_TRUE(readHeartbeat(makeFrame(0x705, {0x00}, 1), 5, state));
  EXPECT_EQ(state, NmtState::kBootUp);
  EXPECT_FALSE(readHeartbeat(makeFrame(0x705, {0x06}, 1), 5, state));
  EXPECT_FALSE(readHeartbeat(makeFrame(0x705, {0x05}, 2), 5, state));
  EXPECT_FALSE(readHeartbeat(makeFrame(0x706, {0x05}, 1), 5, state));
}

// CiA 301, "SDO upload segment" and "SDO download segment": t is bit 4, n bits 3 to 1, c bit 0.
TEST(CanopenMessages, Segments) {
  expectFrame(makeSdoUploadSegment(1, false), 0x601, {0x60});
  expectFrame(makeSdoUploadSegment(1, true), 0x601, {0x70});
  expectFrame(makeSdoDownloadStart(1, {0x2010, 0}, 10), 0x601, {0x21, 0x10, 0x20, 0x00, 0x0A});
  const std::uint8_t data[] = {1, 2, 3, 4, 5, 6, 7};
  expectFrame(makeSdoDownloadSegment(1, false, false, data, 7), 0x601, {0x00, 1, 2, 3, 4, 5, 6, 7});
  expectFrame(makeSdoDownloadSegment(1, true, true, data, 3), 0x601, {0x19, 1, 2, 3});

  SdoReply reply;
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x41, 0x08, 0x10, 0x00, 0x1E}), 1, reply));
  EXPECT_EQ(reply.kind, SdoReply::Kind::kUploadStart);
  EXPECT_EQ(reply.size, 30u);
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x1B, 'e', 'n'}), 1, reply));
  EXPECT_EQ(reply.kind, SdoReply::Kind::kUploadSegment);
  EXPECT_TRUE(reply.toggle && reply.last);
  EXPECT_EQ(reply.size, 2u);
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x30}), 1, reply));
  EXPECT_EQ(reply.kind, SdoReply::Kind::kDownloadSegment);
  EXPECT_TRUE(reply.toggle);
}

// ABB FCAN-01 user's manual, "SDO abort codes".
TEST(CanopenMessages, Aborts) {
  expectFrame(makeSdoAbort(1, {0x1008, 0}, 0x05040000), 0x601, {0x80, 0x08, 0x10, 0x00, 0x00, 0x00, 0x04, 0x05});
  SdoReply reply;
  ASSERT_TRUE(readSdoReply(makeFrame(0x581, {0x80, 0x00, 0x1A, 0x01, 0x41, 0x00, 0x04, 0x06}), 1, reply));
  EXPECT_EQ(reply.kind, SdoReply::Kind::kAbort);
  EXPECT_EQ(reply.abort_code, 0x06040041u);
  EXPECT_EQ(std::string(describeAbort(reply.abort_code)), "the object cannot be mapped to a PDO");
  EXPECT_EQ(std::string(describeAbort(0x06020000)), "no such object");
  EXPECT_EQ(std::string(describeAbort(0x12345678)), "a reason of the device's own");
}

TEST(CanopenMessages, RepliesOfOtherShapesAreNotRead) {
  SdoReply reply;
  EXPECT_FALSE(readSdoReply(makeFrame(0x582, {0x60}), 1, reply));
  EXPECT_FALSE(readSdoReply(makeFrame(0x581, {0x60}, 7), 1, reply));
  EXPECT_FALSE(readSdoReply(makeFrame(0x581, {0xA0}), 1, reply));
  EXPECT_FALSE(readSdoReply(makeFrame(0x581, {0xE0}), 1, reply));
  CanFrame extended = makeFrame(0x581, {0x60});
  extended.extended = true;
  EXPECT_FALSE(readSdoReply(extended, 1, reply));
}

// Every mapping by hand: index, subindex, bits.
TEST(CanopenMessages, Mappings) {
  EXPECT_EQ(calcMapping({0x6040, 0}, 2), 0x60400010u);
  EXPECT_EQ(calcMapping({0x607A, 0}, 4), 0x607A0020u);
  EXPECT_EQ(calcMapping({0x30D1, 2}, 4), 0x30D10220u);
}

TEST(CanopenMessages, NumbersComeBack) {
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    const auto value = static_cast<std::uint32_t>(random());
    std::uint8_t data[4];
    storeNumber(value, 4, data);
    EXPECT_EQ(loadNumber(data, 4), value);
    EXPECT_EQ(loadSigned(data, 4), static_cast<std::int32_t>(value));
    EXPECT_EQ(loadSigned(data, 2), static_cast<std::int16_t>(value & 0xFFFF));
    EXPECT_EQ(loadSigned(data, 1), static_cast<std::int8_t>(value & 0xFF));
  }
}

TEST(CanopenMessages, EveryEmergencyHasWords) {
  for (unsigned code = 0; code <= 0xFFFF; ++code)
    EXPECT_STRNE(describeEmergency(static_cast<std::uint16_t>(code)), "unknown") << code;
  EXPECT_STREQ(describeEmergency(0x2220), "current");
  EXPECT_STREQ(describeEmergency(0xFF07), "additional function");
}

}  // namespace
}  // namespace sinew::canopen
