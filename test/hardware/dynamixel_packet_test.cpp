#include "sinew/hardware/dynamixel_packet.h"

#include <gtest/gtest.h>

#include <random>

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes makePacket(std::uint8_t id, Instruction instruction, const Bytes& parameters) {
  Bytes out;
  appendPacket(id, instruction, parameters.data(), parameters.size(), out);
  return out;
}

struct Packet {
  std::uint8_t id;
  Instruction instruction;
  Bytes parameters;
};

std::vector<Packet> readAll(PacketReader& reader, const Bytes& bytes, std::size_t chunk = 100000) {
  std::vector<Packet> out;
  InstructionView view;
  for (std::size_t i = 0; i < bytes.size(); i += chunk) {
    reader.put(bytes.data() + i, std::min(chunk, bytes.size() - i));
    while (reader.next(view))
      out.push_back({view.id, view.instruction, Bytes(view.parameters, view.parameters + view.size)});
  }
  return out;
}

std::vector<Packet> readAll(const Bytes& bytes, std::size_t chunk = 100000) {
  PacketReader reader;
  return readAll(reader, bytes, chunk);
}

Bytes randomBytes(std::mt19937& random, std::size_t size, bool nasty) {
  // Nasty payloads are made of little but header bytes, so that stuffing happens all the time.
  constexpr std::uint8_t kNasty[] = {0xFF, 0xFF, 0xFD, 0xFD, 0x00};
  Bytes out(size);
  for (std::uint8_t& b : out) b = static_cast<std::uint8_t>(nasty ? kNasty[random() % 5] : random());
  return out;
}

// The packets printed as examples in ROBOTIS' e-Manual, "DYNAMIXEL Protocol 2.0".
struct Example {
  const char* name;
  std::uint8_t id;
  Instruction instruction;
  Bytes parameters;
  Bytes packet;
};

const std::vector<Example>& examples() {
  static const std::vector<Example> kExamples = {
      {"ping", 1, Instruction::kPing, {}, {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4E}},
      {"ping all", 0xFE, Instruction::kPing, {}, {0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x03, 0x00, 0x01, 0x31, 0x42}},
      {"ping status",
       1,
       Instruction::kStatus,
       {0x00, 0x06, 0x04, 0x26},
       {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x55, 0x00, 0x06, 0x04, 0x26, 0x65, 0x5D}},
      {"read",
       1,
       Instruction::kRead,
       {0x84, 0x00, 0x04, 0x00},
       {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x02, 0x84, 0x00, 0x04, 0x00, 0x1D, 0x15}},
      {"read status",
       1,
       Instruction::kStatus,
       {0x00, 0xA6, 0x00, 0x00, 0x00},
       {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x08, 0x00, 0x55, 0x00, 0xA6, 0x00, 0x00, 0x00, 0x8C, 0xC0}},
      {"write",
       1,
       Instruction::kWrite,
       {0x74, 0x00, 0x00, 0x02, 0x00, 0x00},
       {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x09, 0x00, 0x03, 0x74, 0x00, 0x00, 0x02, 0x00, 0x00, 0xCA, 0x89}},
      {"write status",
       1,
       Instruction::kStatus,
       {0x00},
       {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x04, 0x00, 0x55, 0x00, 0xA1, 0x0C}},
      {"reg write",
       1,
       Instruction::kRegWrite,
       {0x68, 0x00, 0xC8, 0x00, 0x00, 0x00},
       {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x09, 0x00, 0x04, 0x68, 0x00, 0xC8, 0x00, 0x00, 0x00, 0xAE, 0x8E}},
      {"action", 1, Instruction::kAction, {}, {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x05, 0x02, 0xCE}},
      {"reboot", 1, Instruction::kReboot, {}, {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x08, 0x2F, 0x4E}},
      {"clear",
       1,
       Instruction::kClear,
       {0x01, 0x44, 0x58, 0x4C, 0x22},
       {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x08, 0x00, 0x10, 0x01, 0x44, 0x58, 0x4C, 0x22, 0xB1, 0xDC}},
      {"sync read",
       0xFE,
       Instruction::kSyncRead,
       {0x84, 0x00, 0x04, 0x00, 0x01, 0x02},
       {0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA}},
      {"sync read status of id 2",
       2,
       Instruction::kStatus,
       {0x00, 0x1F, 0x08, 0x00, 0x00},
       {0xFF, 0xFF, 0xFD, 0x00, 0x02, 0x08, 0x00, 0x55, 0x00, 0x1F, 0x08, 0x00, 0x00, 0xBA, 0xBE}},
      {"sync write",
       0xFE,
       Instruction::kSyncWrite,
       {0x74, 0x00, 0x04, 0x00, 0x01, 0x96, 0x00, 0x00, 0x00, 0x02, 0xAA, 0x00, 0x00, 0x00},
       {0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x11, 0x00, 0x83, 0x74, 0x00, 0x04, 0x00,
        0x01, 0x96, 0x00, 0x00, 0x00, 0x02, 0xAA, 0x00, 0x00, 0x00, 0x82, 0x87}},
      {"fast sync read",
       0xFE,
       Instruction::kFastSyncRead,
       {0x84, 0x00, 0x04, 0x00, 0x03, 0x07, 0x04},
       {0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x0A, 0x00, 0x8A, 0x84, 0x00, 0x04, 0x00, 0x03, 0x07, 0x04, 0x20, 0xF2}},
  };
  return kExamples;
}

// The joint answer that the same page prints for the fast sync read of ids 3, 7 and 4, device after device.
const Bytes kJointAnswer = {0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x19, 0x00, 0x55, 0x00, 0x03, 0xA6,
                            0x00, 0x00, 0x00, 0x84, 0x08, 0x00, 0x07, 0x1F, 0x08, 0x00, 0x00,
                            0x16, 0xCA, 0x00, 0x04, 0xFF, 0x03, 0x00, 0x00, 0xD1, 0x9E};

TEST(DynamixelPacket, WritesTheExamplesOfTheManual) {
  for (const Example& e : examples()) EXPECT_EQ(makePacket(e.id, e.instruction, e.parameters), e.packet) << e.name;
}

TEST(DynamixelPacket, ReadsTheExamplesOfTheManual) {
  for (const Example& e : examples()) {
    const std::vector<Packet> found = readAll(e.packet, 1);
    ASSERT_EQ(found.size(), 1u) << e.name;
    EXPECT_EQ(found[0].id, e.id) << e.name;
    EXPECT_EQ(found[0].instruction, e.instruction) << e.name;
    EXPECT_EQ(found[0].parameters, e.parameters) << e.name;
  }
}

TEST(DynamixelPacket, JointAnswerCarriesTheCrcOfEverythingBefore) {
  for (const std::size_t end : {14u, 22u, 30u}) {
    const std::uint16_t crc = calcCrc(kJointAnswer.data(), end);
    EXPECT_EQ(kJointAnswer[end], crc & 0xFF) << end;
    EXPECT_EQ(kJointAnswer[end + 1], crc >> 8) << end;
  }
  ASSERT_EQ(readAll(kJointAnswer).size(), 1u);
}

TEST(DynamixelPacket, CrcMatchesLongDivision) {
  std::mt19937 random(3);
  for (int n = 0; n < 200; ++n) {
    const Bytes data = randomBytes(random, 1 + random() % 60, false);
    unsigned remainder = 0;  // bit by bit, the message followed by 16 zeros
    for (std::size_t bit = 0; bit < 8 * data.size() + 16; ++bit) {
      const unsigned in = bit < 8 * data.size() ? (data[bit / 8] >> (7 - bit % 8)) & 1u : 0u;
      remainder = (remainder << 1) | in;
      if ((remainder & 0x10000u) != 0) remainder ^= 0x18005u;
    }
    EXPECT_EQ(calcCrc(data.data(), data.size()), remainder);
  }
}

TEST(DynamixelPacket, RoundTripWithStuffing) {
  std::mt19937 random(1);
  for (int n = 0; n < 20000; ++n) {
    const Bytes payload = randomBytes(random, random() % 40, n % 2 == 0);
    const auto id = static_cast<std::uint8_t>(random() % 0xFD);
    const Bytes packet = makePacket(id, Instruction::kWrite, payload);
    for (std::size_t i = 8; i + 4 < packet.size(); ++i)  // no header inside the body
      ASSERT_FALSE(packet[i] == 0xFF && packet[i + 1] == 0xFF && packet[i + 2] == 0xFD && packet[i + 3] == 0x00);
    const std::vector<Packet> found = readAll(packet, 1 + random() % 20);
    ASSERT_EQ(found.size(), 1u);
    ASSERT_EQ(found[0].parameters, payload);
    ASSERT_EQ(found[0].id, id);
  }
}

TEST(DynamixelPacket, FindsPacketsBetweenNoise) {
  std::mt19937 random(2);
  Bytes stream;
  std::vector<Bytes> sent;
  for (int n = 0; n < 300; ++n) {
    Bytes noise(random() % 30);
    for (std::uint8_t& b : noise) b = static_cast<std::uint8_t>(random() % 0xFD);  // holds no start of a header
    stream.insert(stream.end(), noise.begin(), noise.end());
    sent.push_back(randomBytes(random, random() % 20, n % 2 == 0));
    const Bytes packet = makePacket(5, Instruction::kWrite, sent.back());
    stream.insert(stream.end(), packet.begin(), packet.end());
  }
  const std::vector<Packet> found = readAll(stream, 7);
  ASSERT_EQ(found.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(found[i].parameters, sent[i]);
}

TEST(DynamixelPacket, FalseHeaderDoesNotHideTheTruePacketBehindIt) {
  const Bytes good = makePacket(1, Instruction::kWrite, {1, 2, 3});
  for (const Bytes& false_header :
       {Bytes{0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x0A, 0x00}, Bytes{0xFF, 0xFF, 0xFD, 0x00}, Bytes{0xFF, 0xFF, 0xFF},
        Bytes{0xFF, 0xFF, 0xFD, 0x00, 0x01, 0xFF, 0xFF}, Bytes{0xFF, 0xFF, 0xFD, 0x00, 0xFF, 0x03, 0x00}}) {
    Bytes stream = false_header;
    stream.insert(stream.end(), good.begin(), good.end());
    stream.insert(stream.end(), good.begin(), good.end());
    EXPECT_EQ(readAll(stream).size(), 2u) << false_header.size();
  }
}

TEST(DynamixelPacket, ImpossibleLengthIsNotWaitedFor) {
  PacketReader reader;
  const Bytes huge = {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0xFF, 0xFF, 0x55};
  const Bytes good = makePacket(1, Instruction::kWrite, {1});
  EXPECT_TRUE(readAll(reader, huge).empty());
  EXPECT_EQ(reader.rejects().header, 1u);
  EXPECT_EQ(readAll(reader, good).size(), 1u) << "at once, without 65535 bytes more";
  reader.setMaxFrame(good.size() - 1);
  EXPECT_TRUE(readAll(reader, good).empty());
  EXPECT_EQ(reader.rejects().header, 2u);
}

TEST(DynamixelPacket, CountsRejectsByReason) {
  PacketReader reader;
  Bytes bad_crc = makePacket(1, Instruction::kWrite, {1, 2, 3});
  bad_crc.back() = static_cast<std::uint8_t>(bad_crc.back() ^ 1);
  readAll(reader, bad_crc);
  EXPECT_EQ(reader.rejects().crc, 1u);
  EXPECT_EQ(reader.skipped(), bad_crc.size());
  Bytes unstuffed = {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x03, 0xFF, 0xFF, 0xFD, 0x01};
  const std::uint16_t crc = calcCrc(unstuffed.data(), unstuffed.size());
  unstuffed.push_back(static_cast<std::uint8_t>(crc));
  unstuffed.push_back(static_cast<std::uint8_t>(crc >> 8));
  EXPECT_TRUE(readAll(reader, unstuffed).empty());
  EXPECT_EQ(reader.rejects().stuffing, 1u);
}

// One to three flipped bits outside the length field are beyond what CRC-16 can miss, and so is every burst of up to 16
// bits before the CRC itself (whose bytes are sent low byte first, which tears bursts apart).
TEST(DynamixelPacket, DamagedPacketsAreNeverAccepted) {
  std::mt19937 random(4);
  std::uint64_t accepted = 0, flips = 0;
  for (int n = 0; n < 400000; ++n) {
    Bytes packet = makePacket(static_cast<std::uint8_t>(1 + random() % 8), Instruction::kStatus,
                              randomBytes(random, 1 + random() % 24, n % 4 == 0));
    const Bytes sent = packet;
    const auto flip = [&](std::size_t bit) {
      if (bit / 8 == 5 || bit / 8 == 6) return;
      packet[bit / 8] = static_cast<std::uint8_t>(packet[bit / 8] ^ (1u << (7 - bit % 8)));
      ++flips;
    };
    const std::size_t bits = 8 * packet.size();
    if (n % 2 == 0) {
      for (std::size_t k = 1 + random() % 3; k > 0; --k) flip(random() % bits);
    } else {
      const std::size_t first = 56 + random() % (bits - 87);
      for (std::size_t bit = first; bit < first + 16; ++bit)
        if (bit == first || random() % 2 == 0) flip(bit);
    }
    if (packet == sent) continue;
    accepted += readAll(packet).size();
  }
  EXPECT_EQ(accepted, 0u);
  EXPECT_GT(flips, 1000000u);
}

TEST(DynamixelPacket, TruncatedPacketsAreNeverAccepted) {
  std::mt19937 random(5);
  for (int n = 0; n < 5000; ++n) {
    const Bytes packet = makePacket(1, Instruction::kStatus, randomBytes(random, 1 + random() % 24, n % 2 == 0));
    Bytes cut(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(random() % packet.size()));
    EXPECT_TRUE(readAll(cut).empty());
    cut.insert(cut.end(), packet.begin(), packet.end());
    cut.insert(cut.end(), packet.begin(), packet.end());
    const std::vector<Packet> found = readAll(cut);
    ASSERT_FALSE(found.empty()) << "found again behind the cut";
    ASSERT_LE(found.size(), 2u);
    for (const Packet& p : found) ASSERT_EQ(makePacket(p.id, p.instruction, p.parameters), packet);
  }
}

}  // namespace
}  // namespace sinew
