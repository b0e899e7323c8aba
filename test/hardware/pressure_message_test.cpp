#include "sinew/hardware/pressure_message.h"

#include <gtest/gtest.h>

#include "pressure_examples.h"
#include "sinew/hardware/cobs.h"

namespace sinew {
namespace {

using Bytes = PressureExample::Bytes;
using Progress = PressureFrameReader::Progress;

class PressureMessage : public testing::Test {
 protected:
  const PressureExample& example(const std::string& name) { return examples_.at(name); }

  PressureAnswer decode(const std::string& name) {
    const PressureExample& e = example(name);
    Bytes packet;
    EXPECT_TRUE(decodeCobs(e.frame.data(), e.frame.size() - 1, packet));
    EXPECT_EQ(packet, e.packet);
    PressureAnswer answer;
    EXPECT_TRUE(decodePressureAnswer(packet.data(), packet.size(), answer)) << name;
    EXPECT_EQ(answer.address, e.at("address"));
    EXPECT_EQ(answer.sequence, e.at("sequence"));
    return answer;
  }

  static CanFrame toFrame(const PressureExample::Can& can) {
    CanFrame frame;
    frame.id = can.id;
    frame.extended = true;
    frame.size = static_cast<std::uint8_t>(can.data.size());
    std::copy(can.data.begin(), can.data.end(), frame.data.begin());
    return frame;
  }

  PressureAnswer decodeCan(const std::string& name) {
    PressureFrameReader reader(5);
    Progress progress = Progress::kForeign;
    for (const PressureExample::Can& can : example(name).can) {
      EXPECT_NE(progress, Progress::kWhole);
      progress = reader.take(toFrame(can));
    }
    EXPECT_EQ(progress, Progress::kWhole) << name;
    return reader.answer();
  }

  PressureRequest makeRequest(const std::string& name, PressureType type) {
    PressureRequest request;
    request.type = type;
    request.sequence = static_cast<std::uint16_t>(example(name).at("sequence"));
    return request;
  }

  void expectEncodes(const std::string& name, const PressureRequest& request) {
    const PressureExample& e = example(name);
    if (!e.frame.empty()) {
      Bytes frame;
      appendPressureRequest(5, request, frame);
      EXPECT_EQ(frame, e.frame) << name;
      EXPECT_EQ(frame.size(), pressureFrameSize(request.type, 2)) << name;
    }
    std::vector<CanFrame> frames;
    appendPressureFrames(5, request, frames);
    ASSERT_EQ(frames.size(), e.can.size()) << name;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_TRUE(frames[i].extended);
      EXPECT_EQ(frames[i].id, e.can[i].id) << name;
      EXPECT_EQ(Bytes(frames[i].data.begin(), frames[i].data.begin() + frames[i].size), e.can[i].data) << name;
    }
  }

  PressureRequest makeSetPoints() {
    const PressureExample& e = example("SET_POINTS");
    PressureRequest request = makeRequest("SET_POINTS", PressureType::kSetPoints);
    request.count = static_cast<std::uint8_t>(e.at("channels"));
    for (int i = 0; i < request.count; ++i) {
      PressureSetPoint& s = request.set_points[static_cast<std::size_t>(i)];
      s.mode = static_cast<PressureMode>(e.at("mode", i));
      s.pressure = static_cast<std::int32_t>(e.at("pressure", i));
      s.limit = static_cast<std::int32_t>(e.at("limit", i));
      s.ramp = static_cast<std::uint32_t>(e.at("ramp", i));
    }
    return request;
  }

  PressureConfiguration makeConfiguration() {
    const PressureExample& e = example("CONFIGURE");
    PressureConfiguration c;
    c.timeout = static_cast<std::uint16_t>(e.at("timeout"));
    c.count = static_cast<std::uint8_t>(e.at("channels"));
    for (int i = 0; i < c.count; ++i) {
      PressureChannelConfiguration& channel = c.channels[static_cast<std::size_t>(i)];
      channel.maximum = static_cast<std::int32_t>(e.at("maximum", i));
      channel.ramp = static_cast<std::uint32_t>(e.at("ramp", i));
      channel.on_timeout = static_cast<PressureMode>(e.at("on_timeout", i));
    }
    return c;
  }

  void expectState(const PressureState& s) {
    const PressureExample& e = example("STATE");
    EXPECT_EQ(s.uptime, e.at("uptime"));
    EXPECT_EQ(s.supply, e.at("supply"));
    EXPECT_EQ(s.temperature, e.at("temperature"));
    EXPECT_EQ(s.age, e.at("age"));
    EXPECT_EQ(s.accepted, e.at("accepted"));
    EXPECT_EQ(s.flags, e.at("flags"));
    EXPECT_EQ(static_cast<int>(s.refusal), e.at("refusal"));
    ASSERT_EQ(s.count, e.at("channels"));
    for (int i = 0; i < s.count; ++i) {
      EXPECT_EQ(s.channels[static_cast<std::size_t>(i)].pressure, e.at("pressure", i));
      EXPECT_EQ(s.channels[static_cast<std::size_t>(i)].status, e.at("status", i));
      EXPECT_EQ(s.channels[static_cast<std::size_t>(i)].faults, e.at("faults", i));
    }
  }

  std::map<std::string, PressureExample> examples_ = PressureExample::load();
};

TEST_F(PressureMessage, CrcHasTheCheckValueOfTheCatalogue) {
  // Catalogue of parametrised CRC algorithms, CRC-16/IBM-3740.
  EXPECT_EQ(calcPressureCrc(reinterpret_cast<const std::uint8_t*>("123456789"), 9), 0x29B1);
}

TEST_F(PressureMessage, EncodesTheRequestsOfTheDocument) {
  expectEncodes("HELLO", makeRequest("HELLO", PressureType::kHello));
  expectEncodes("READ_STATE", makeRequest("READ_STATE", PressureType::kReadState));
  PressureRequest clear = makeRequest("CLEAR_FAULTS", PressureType::kClearFaults);
  clear.mask = static_cast<std::uint16_t>(example("CLEAR_FAULTS").at("mask"));
  expectEncodes("CLEAR_FAULTS", clear);
  PressureRequest configure = makeRequest("CONFIGURE", PressureType::kConfigure);
  configure.configuration = makeConfiguration();
  expectEncodes("CONFIGURE", configure);
  PressureRequest set_points = makeSetPoints();
  expectEncodes("SET_POINTS", set_points);
  set_points.type = PressureType::kBounds;
  expectEncodes("BOUNDS", set_points);
}

TEST_F(PressureMessage, DecodesTheAnswersOfTheDocument) {
  for (const bool can : {false, true}) {
    const auto answer = [&](const char* name) { return can ? decodeCan(name) : decode(name); };
    const PressureAnswer a = answer("IDENTITY");
    const PressureIdentity& identity = a.identity;
    const PressureExample& e = example("IDENTITY");
    EXPECT_EQ(a.type, PressureType::kIdentity);
    EXPECT_EQ(identity.version, e.at("version"));
    EXPECT_EQ(identity.firmware_major, e.at("major"));
    EXPECT_EQ(identity.firmware_minor, e.at("minor"));
    EXPECT_EQ(identity.channels, e.at("channels"));
    EXPECT_EQ(identity.serial_number, e.at("serial"));
    EXPECT_EQ(identity.range_min, e.at("min"));
    EXPECT_EQ(identity.range_max, e.at("max"));
    EXPECT_TRUE(answer("CONFIGURATION").configuration == makeConfiguration());
    EXPECT_EQ(answer("STATE").sequence, example("STATE").at("sequence"));
    expectState(answer("STATE").state);
    EXPECT_EQ(static_cast<int>(answer("ERROR").refused), example("ERROR").at("refused"));
    EXPECT_EQ(static_cast<int>(answer("ERROR").reason), example("ERROR").at("reason"));
  }
}

TEST_F(PressureMessage, RequestsAreNoAnswers) {
  PressureAnswer answer;
  for (const auto& entry : examples_) {
    const Bytes& packet = entry.second.packet;
    if (packet.empty()) continue;
    EXPECT_EQ(decodePressureAnswer(packet.data(), packet.size(), answer), packet[1] >= 0x80) << entry.first;
  }
}

TEST_F(PressureMessage, AnyFlippedBitIsNoticed) {
  PressureAnswer answer;
  for (const char* name : {"IDENTITY", "STATE", "ERROR"}) {
    const Bytes packet = example(name).packet;
    for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
      Bytes damaged = packet;
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1u << bit % 8));
      EXPECT_FALSE(decodePressureAnswer(damaged.data(), damaged.size(), answer));
    }
  }
}

TEST_F(PressureMessage, WrongLengthsAndCountsAreRefusedThoughTheirCrcIsRight) {
  PressureAnswer answer;
  const auto refuses = [&](Bytes packet) {
    const std::uint16_t crc = calcPressureCrc(packet.data(), packet.size() - 2);
    packet[packet.size() - 2] = static_cast<std::uint8_t>(crc);
    packet[packet.size() - 1] = static_cast<std::uint8_t>(crc >> 8);
    return !decodePressureAnswer(packet.data(), packet.size(), answer);
  };
  for (const char* name : {"IDENTITY", "CONFIGURATION", "STATE", "ERROR"}) {
    Bytes packet = example(name).packet;
    EXPECT_FALSE(refuses(packet));
    for (std::size_t size = 0; size < packet.size(); ++size) {
      if (size < 6) {
        EXPECT_FALSE(decodePressureAnswer(packet.data(), size, answer));
      } else {
        EXPECT_TRUE(refuses(Bytes(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size))));
      }
    }
    packet.push_back(0);
    EXPECT_TRUE(refuses(packet));
  }
  Bytes many = example("STATE").packet;
  many[4 + 14] = 17;
  many.resize(4 + 15 + 17 * 6 + 2);
  EXPECT_TRUE(refuses(many)) << "more channels than the protocol knows";
}

TEST_F(PressureMessage, CanAnswersNeedAllTheirParts) {
  for (const char* name : {"IDENTITY", "CONFIGURATION", "STATE"}) {
    const auto& frames = example(name).can;
    for (std::size_t missing = 0; missing + 1 < frames.size(); ++missing) {
      if (missing == 1 && std::string(name) == "CONFIGURATION") continue;
      PressureFrameReader reader(5);
      Progress progress = Progress::kForeign;
      for (std::size_t i = 0; i < frames.size(); ++i)
        if (i != missing) progress = reader.take(toFrame(frames[i]));
      const bool shorter = std::string(name) == "STATE" && missing == 1;  // as of a board with one channel less
      EXPECT_EQ(progress, shorter ? Progress::kWhole : Progress::kDamaged) << name << missing;
      if (shorter) {
        EXPECT_EQ(reader.answer().state.count, 1) << "which the count tells";
      }
    }
  }
}

TEST_F(PressureMessage, PartsOfDifferentStatesAreNotMixed) {
  PressureFrameReader reader(5);
  std::vector<CanFrame> frames;
  for (const auto& can : example("STATE").can) frames.push_back(toFrame(can));
  CanFrame older = frames[0];
  older.data[6] = static_cast<std::uint8_t>(older.data[6] - 1);
  reader.take(older);
  for (std::size_t i = 1; i + 1 < frames.size(); ++i) EXPECT_EQ(reader.take(frames[i]), Progress::kPart);
  EXPECT_EQ(reader.take(frames.back()), Progress::kDamaged);
}

TEST_F(PressureMessage, CanFramesOfImpossibleShapeAreDamaged) {
  for (const char* name : {"IDENTITY", "CONFIGURATION", "STATE", "ERROR"}) {
    for (const auto& can : example(name).can) {
      PressureFrameReader reader(5);
      CanFrame frame = toFrame(can);
      frame.size = static_cast<std::uint8_t>(frame.size - 1);
      EXPECT_EQ(reader.take(frame), Progress::kDamaged);
      frame = toFrame(can);
      frame.id = (frame.id & ~0xFFu) | 0x40;
      EXPECT_EQ(reader.take(frame), Progress::kDamaged);
      frame = toFrame(can);
      frame.remote = true;
      EXPECT_EQ(reader.take(frame), Progress::kDamaged);
      frame = toFrame(can);
      frame.extended = false;
      EXPECT_EQ(reader.take(frame), Progress::kForeign);
      frame = toFrame(can);
      frame.id += 0x100;
      EXPECT_EQ(reader.take(frame), Progress::kForeign);
    }
  }
}

}  // namespace
}  // namespace sinew
