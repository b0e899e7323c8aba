#include <gtest/gtest.h>
#include <sinew_board_codec.h>

#include <random>

#include "pressure_examples.h"

namespace sinew {
namespace {

using Bytes = PressureExample::Bytes;

class SinewBoardCodec : public testing::Test {
 protected:
  const PressureExample& example(const std::string& name) { return examples_.at(name); }

  sinew_request decode(const std::string& name) {
    const PressureExample& e = example(name);
    Bytes packet(e.frame.size());
    packet.resize(sinew_unstuff(e.frame.data(), e.frame.size() - 1, packet.data()));
    EXPECT_EQ(packet, e.packet);
    EXPECT_TRUE(sinew_packet_is_sound(packet.data(), packet.size()));
    sinew_request request{};
    EXPECT_EQ(sinew_decode_request(packet.data(), packet.size(), &request), SINEW_ACCEPTED);
    EXPECT_EQ(request.address, e.at("address"));
    EXPECT_EQ(request.sequence, e.at("sequence"));
    return request;
  }

  sinew_can_request decodeCan(const std::string& name, std::size_t i) {
    const PressureExample::Can& e = example(name).can.at(i);
    sinew_can_frame frame{};
    frame.id = e.id;
    frame.size = static_cast<std::uint8_t>(e.data.size());
    std::copy(e.data.begin(), e.data.end(), frame.data);
    EXPECT_TRUE(sinew_can_is_request(frame.id, 5));
    EXPECT_FALSE(sinew_can_is_request(frame.id, 6));
    sinew_can_request request{};
    EXPECT_EQ(sinew_can_decode(&frame, &request), SINEW_ACCEPTED);
    return request;
  }

  void expectEncodes(const std::string& name, sinew_answer answer) {
    const PressureExample& e = example(name);
    answer.address = static_cast<std::uint8_t>(e.at("address"));
    answer.sequence = static_cast<std::uint16_t>(e.at("sequence"));
    Bytes frame(SINEW_MAX_FRAME);
    frame.resize(sinew_encode_answer(&answer, frame.data()));
    EXPECT_EQ(frame, e.frame) << name;
    sinew_can_frame frames[SINEW_MAX_CAN_FRAMES];
    ASSERT_EQ(sinew_can_encode(&answer, frames), e.can.size()) << name;
    for (std::size_t i = 0; i < e.can.size(); ++i) {
      EXPECT_EQ(frames[i].id, e.can[i].id) << name;
      EXPECT_EQ(Bytes(frames[i].data, frames[i].data + frames[i].size), e.can[i].data) << name << " " << i;
    }
  }

  std::map<std::string, PressureExample> examples_ = PressureExample::load();
};

TEST_F(SinewBoardCodec, TheDocumentHasAnExampleOfEveryMessage) {
  EXPECT_EQ(examples_.size(), 10u);
}

TEST_F(SinewBoardCodec, CrcHasTheCheckValueOfTheCatalogue) {
  // Catalogue of parametrised CRC algorithms, CRC-16/IBM-3740.
  EXPECT_EQ(sinew_crc(reinterpret_cast<const std::uint8_t*>("123456789"), 9), 0x29B1);
}

TEST_F(SinewBoardCodec, DecodesTheRequestsOfTheDocument) {
  EXPECT_EQ(decode("HELLO").as.version, 1);
  EXPECT_EQ(decode("READ_STATE").type, SINEW_READ_STATE);
  EXPECT_EQ(decode("CLEAR_FAULTS").as.mask, example("CLEAR_FAULTS").at("mask"));
  const sinew_configuration c = decode("CONFIGURE").as.configuration;
  EXPECT_EQ(c.timeout, example("CONFIGURE").at("timeout"));
  ASSERT_EQ(c.count, 2);
  const sinew_request set_points = decode("SET_POINTS");
  ASSERT_EQ(set_points.as.set_points.count, 2);
  for (int i = 0; i < 2; ++i) {
    const auto& channel = c.channels[i];
    EXPECT_EQ(channel.maximum, example("CONFIGURE").at("maximum", i));
    EXPECT_EQ(channel.ramp, example("CONFIGURE").at("ramp", i));
    EXPECT_EQ(channel.on_timeout, example("CONFIGURE").at("on_timeout", i));
    const auto& s = set_points.as.set_points.channels[i];
    EXPECT_EQ(s.mode, example("SET_POINTS").at("mode", i));
    EXPECT_EQ(s.pressure, example("SET_POINTS").at("pressure", i));
    EXPECT_EQ(s.limit, example("SET_POINTS").at("limit", i));
    EXPECT_EQ(s.ramp, example("SET_POINTS").at("ramp", i));
  }
}

TEST_F(SinewBoardCodec, DecodesTheCanRequestsOfTheDocument) {
  EXPECT_EQ(decodeCan("HELLO", 0).version, 1);
  EXPECT_EQ(decodeCan("READ_STATE", 0).sequence, example("READ_STATE").at("sequence"));
  EXPECT_EQ(decodeCan("CLEAR_FAULTS", 0).sequence, example("CLEAR_FAULTS").at("sequence"));
  EXPECT_EQ(decodeCan("CLEAR_FAULTS", 0).mask, example("CLEAR_FAULTS").at("mask"));
  for (int i = 0; i < 2; ++i) {
    const auto n = static_cast<std::size_t>(i);
    EXPECT_EQ(decodeCan("CONFIGURE", n).pressure, example("CONFIGURE").at("maximum", i));
    EXPECT_EQ(decodeCan("CONFIGURE", n).ramp, example("CONFIGURE").at("ramp", i));
    EXPECT_EQ(decodeCan("BOUNDS", n).pressure, example("BOUNDS").at("limit", i));
    EXPECT_EQ(decodeCan("BOUNDS", n).ramp, example("BOUNDS").at("ramp", i));
    const sinew_can_request s = decodeCan("SET_POINTS", n);
    EXPECT_EQ(s.index, i);
    EXPECT_EQ(s.pressure, example("SET_POINTS").at("pressure", i));
    EXPECT_EQ(s.sequence, example("SET_POINTS").at("sequence"));
    EXPECT_EQ(s.mode, example("SET_POINTS").at("mode", i));
  }
  const sinew_can_request last = decodeCan("CONFIGURE", 2);
  EXPECT_EQ(last.timeout, example("CONFIGURE").at("timeout"));
  EXPECT_EQ(last.mask, 2) << "channel 1 seals";
  EXPECT_EQ(last.count, 2);
}

TEST_F(SinewBoardCodec, EncodesTheAnswersOfTheDocument) {
  sinew_answer identity{};
  identity.type = SINEW_IDENTITY;
  const PressureExample& e = example("IDENTITY");
  identity.as.identity.firmware_major = static_cast<std::uint8_t>(e.at("major"));
  identity.as.identity.firmware_minor = static_cast<std::uint8_t>(e.at("minor"));
  identity.as.identity.channels = static_cast<std::uint8_t>(e.at("channels"));
  identity.as.identity.serial_number = static_cast<std::uint32_t>(e.at("serial"));
  identity.as.identity.range_min = static_cast<std::int32_t>(e.at("min"));
  identity.as.identity.range_max = static_cast<std::int32_t>(e.at("max"));
  expectEncodes("IDENTITY", identity);

  sinew_answer configuration{};
  configuration.type = SINEW_CONFIGURATION;
  configuration.as.configuration = decode("CONFIGURE").as.configuration;
  expectEncodes("CONFIGURATION", configuration);

  sinew_answer error{};
  error.type = SINEW_ERROR;
  error.as.error.type = static_cast<std::uint8_t>(example("ERROR").at("refused"));
  error.as.error.reason = static_cast<std::uint8_t>(example("ERROR").at("reason"));
  expectEncodes("ERROR", error);
}

TEST_F(SinewBoardCodec, EncodesTheStateOfTheDocument) {
  const PressureExample& e = example("STATE");
  sinew_answer answer{};
  answer.type = SINEW_STATE;
  sinew_state& s = answer.as.state;
  s.uptime = static_cast<std::uint32_t>(e.at("uptime"));
  s.supply = static_cast<std::uint16_t>(e.at("supply"));
  s.temperature = static_cast<std::int16_t>(e.at("temperature"));
  s.age = static_cast<std::uint16_t>(e.at("age"));
  s.accepted = static_cast<std::uint16_t>(e.at("accepted"));
  s.flags = static_cast<std::uint8_t>(e.at("flags"));
  s.refusal = static_cast<std::uint8_t>(e.at("refusal"));
  s.count = static_cast<std::uint8_t>(e.at("channels"));
  for (int i = 0; i < s.count; ++i) {
    s.channels[i].pressure = static_cast<std::int32_t>(e.at("pressure", i));
    s.channels[i].status = static_cast<std::uint8_t>(e.at("status", i));
    s.channels[i].faults = static_cast<std::uint8_t>(e.at("faults", i));
  }
  expectEncodes("STATE", answer);
}

TEST_F(SinewBoardCodec, StuffingComesBackWithoutZeros) {
  std::mt19937 random(7);
  for (std::size_t size = 1; size <= 254; ++size) {
    Bytes data(size);
    for (std::uint8_t& b : data) b = static_cast<std::uint8_t>(random() % (1 + size % 40));
    if (size == 254) std::fill(data.begin(), data.end(), std::uint8_t{1});
    Bytes stuffed(size + 1), back(size + 2);
    ASSERT_EQ(sinew_stuff(data.data(), size, stuffed.data()), size + 1);
    EXPECT_EQ(std::count(stuffed.begin(), stuffed.end(), 0), 0);
    back.resize(sinew_unstuff(stuffed.data(), stuffed.size(), back.data()));
    EXPECT_EQ(back, data);
  }
}

TEST_F(SinewBoardCodec, RefusesBrokenStuffing) {
  std::uint8_t out[8];
  for (const Bytes& broken : {Bytes{5, 1, 2, 3}, Bytes{0}, Bytes{3, 1, 0}, Bytes{2, 1, 0}})
    EXPECT_EQ(sinew_unstuff(broken.data(), broken.size(), out), 0u);
}

TEST_F(SinewBoardCodec, AnyFlippedBitIsNoticed) {
  const Bytes packet = example("SET_POINTS").packet;
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    Bytes damaged = packet;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1u << bit % 8));
    EXPECT_FALSE(sinew_packet_is_sound(damaged.data(), damaged.size()));
  }
}

TEST_F(SinewBoardCodec, WrongLengthsAreRefusedWhateverTheyHold) {
  for (const auto& entry : examples_) {
    if (entry.second.packet.empty() || entry.second.packet[1] >= 0x80) continue;
    Bytes packet = entry.second.packet;
    packet.insert(packet.end() - 2, 0);
    sinew_request request{};
    EXPECT_EQ(sinew_decode_request(packet.data(), packet.size(), &request), SINEW_WRONG_LENGTH) << entry.first;
    if (entry.first == "READ_STATE") continue;
    packet.erase(packet.end() - 4, packet.end() - 2);
    EXPECT_EQ(sinew_decode_request(packet.data(), packet.size(), &request), SINEW_WRONG_LENGTH) << entry.first;
  }
}

}  // namespace
}  // namespace sinew
