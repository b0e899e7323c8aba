#include "sinew/hardware/simulated_object_dictionary.h"

#include <gtest/gtest.h>

#include <string>

namespace sinew {
namespace {

using Bytes = std::array<std::uint8_t, 8>;
using Mapping = SimulatedObjectDictionary::Mapping;
constexpr std::uint8_t kNode = 2;

class Server : public testing::Test {
 protected:
  Server() {
    dictionary.add({0x1000, 0, 4, false, false, Mapping::kNone, 0x00020192, 0, 0, 0x00020192});
    dictionary.add({0x6040, 0, 2, false, true, Mapping::kReceive, 0, 0, 0xFFFF, 0});
    dictionary.add({0x607A, 0, 4, true, true, Mapping::kReceive, 0, -1000, 1000, 0});
    dictionary.addText(0x1008, "a drive of some sort", 0);
    dictionary.addText(0x2010, "", 12);
  }
  Bytes ask(const Bytes& request) {
    CanFrame frame, reply;
    frame.id = 0x600u + kNode;
    frame.size = 8;
    frame.data = request;
    answered = server.serve(frame, reply);
    EXPECT_EQ(reply.id, answered ? 0x580u + kNode : 0u);
    return reply.data;
  }

  SimulatedObjectDictionary dictionary;
  SimulatedSdoServer server{kNode, dictionary};
  bool answered = false;
};

// CiA 301, "SDO protocols": the bytes by hand.
TEST_F(Server, AnswersExpedited) {
  EXPECT_EQ(ask({0x40, 0x00, 0x10, 0x00}), (Bytes{0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00}));
  EXPECT_EQ(ask({0x40, 0x40, 0x60, 0x00}), (Bytes{0x4B, 0x40, 0x60, 0x00}));
  EXPECT_EQ(ask({0x2B, 0x40, 0x60, 0x00, 0x0F}), (Bytes{0x60, 0x40, 0x60, 0x00}));
  EXPECT_EQ(dictionary.get(0x6040), 0x0F);
  ask({0x23, 0x7A, 0x60, 0x00, 0xFE, 0xFF, 0xFF, 0xFF});
  EXPECT_EQ(dictionary.get(0x607A), -2);
}

TEST_F(Server, RefusesWithTheReason) {
  const auto code = [](const Bytes& reply) {
    EXPECT_EQ(reply[0], 0x80);
    return static_cast<std::uint32_t>(reply[4] | reply[5] << 8 | reply[6] << 16) | std::uint32_t{reply[7]} << 24;
  };
  EXPECT_EQ(code(ask({0x40, 0x99, 0x99, 0x00})), 0x06020000u);
  EXPECT_EQ(code(ask({0x40, 0x00, 0x10, 0x01})), 0x06090011u);
  EXPECT_EQ(code(ask({0x23, 0x00, 0x10, 0x00})), 0x06010002u);
  EXPECT_EQ(code(ask({0x23, 0x40, 0x60, 0x00})), 0x06070012u);
  EXPECT_EQ(code(ask({0x2F, 0x40, 0x60, 0x00})), 0x06070013u);
  EXPECT_EQ(code(ask({0x23, 0x7A, 0x60, 0x00, 0xE9, 0x03})), 0x06090031u);
  EXPECT_EQ(code(ask({0x23, 0x7A, 0x60, 0x00, 0x17, 0xFC, 0xFF, 0xFF})), 0x06090032u);
  EXPECT_EQ(code(ask({0x60})), 0x05040001u);
  EXPECT_EQ(code(ask({0xC0})), 0x05040001u);
  EXPECT_EQ(code(ask({0x21, 0x10, 0x20, 0x00, 0, 0, 1, 0})), 0x05040005u);
  dictionary.setHooks([](std::uint16_t, std::uint8_t, std::int64_t) { return 0x08000022u; }, {});
  EXPECT_EQ(code(ask({0x2B, 0x40, 0x60, 0x00, 0x06})), 0x08000022u);
  ask({0x80});
  EXPECT_FALSE(answered);
}

TEST_F(Server, UploadsInSegments) {
  EXPECT_EQ(ask({0x40, 0x08, 0x10, 0x00}), (Bytes{0x41, 0x08, 0x10, 0x00, 20}));
  EXPECT_EQ(ask({0x60}), (Bytes{0x00, 'a', ' ', 'd', 'r', 'i', 'v', 'e'}));
  EXPECT_EQ(ask({0x70}), (Bytes{0x10, ' ', 'o', 'f', ' ', 's', 'o', 'm'}));
  EXPECT_EQ(ask({0x60}), (Bytes{0x03, 'e', ' ', 's', 'o', 'r', 't'}));
  EXPECT_EQ(ask({0x70})[0], 0x80);
  ask({0x40, 0x08, 0x10, 0x00});
  EXPECT_EQ(ask({0x70}), (Bytes{0x80, 0x08, 0x10, 0x00, 0x00, 0x00, 0x03, 0x05}));
}

TEST_F(Server, DownloadsInSegments) {
  EXPECT_EQ(ask({0x21, 0x10, 0x20, 0x00, 9}), (Bytes{0x60, 0x10, 0x20, 0x00}));
  EXPECT_EQ(ask({0x00, 't', 'e', 'n', 'd', 'o', 'n', ' '}), (Bytes{0x20}));
  EXPECT_EQ(ask({0x1B, '1', '2'}), (Bytes{0x30}));
  std::vector<std::uint8_t> data;
  EXPECT_EQ(dictionary.read(0x2010, 0, data), 0u);
  EXPECT_EQ(std::string(data.begin(), data.end()), "tendon 12");

  ask({0x21, 0x10, 0x20, 0x00, 9});
  EXPECT_EQ(ask({0x01, 1, 2, 3, 4, 5, 6, 7}), (Bytes{0x80, 0x10, 0x20, 0x00, 0x10, 0x00, 0x07, 0x06}));
  ask({0x20, 0x10, 0x20, 0x00});
  ask({0x00, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(ask({0x11, 1, 2, 3, 4, 5, 6, 7}), (Bytes{0x80, 0x10, 0x20, 0x00, 0x12, 0x00, 0x07, 0x06}));
}

TEST_F(Server, ForgetsATransferWhenAnotherBegins) {
  ask({0x40, 0x08, 0x10, 0x00});
  ask({0x40, 0x40, 0x60, 0x00});
  EXPECT_EQ(ask({0x60})[0], 0x80);
}

TEST_F(Server, ResetsARangeOfIndices) {
  dictionary.set(0x6040, 0, 15);
  dictionary.set(0x607A, 0, 7);
  dictionary.reset(0x6041, 0xFFFF);
  EXPECT_EQ(dictionary.get(0x6040), 15);
  EXPECT_EQ(dictionary.get(0x607A), 0);
  EXPECT_THROW(dictionary.get(0x9999), std::logic_error);
}

}  // namespace
}  // namespace sinew
