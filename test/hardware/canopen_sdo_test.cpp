#include "sinew/hardware/canopen_sdo.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "sinew/hardware/simulated_object_dictionary.h"

namespace sinew {
namespace {

constexpr std::uint8_t kNode = 3;
constexpr int kTries = 3;
const Duration kTimeout = duration(0.1);
using Status = CanopenSdo::Status;
using Bytes = std::array<std::uint8_t, 8>;

struct Line : CanSender {
  bool send(const CanFrame& frame) override {
    frames.push_back(frame);
    return true;
  }
  std::vector<CanFrame> frames;
};

CanFrame makeReply(const Bytes& data, std::uint8_t node = kNode) {
  CanFrame frame;
  frame.id = 0x580u + node;
  frame.size = 8;
  frame.data = data;
  return frame;
}

class Client : public testing::Test {
 protected:
  void update(double wait = 0) {
    now += duration(wait);
    sdo.update(now, line);
  }
  const Bytes& lastSent() const { return line.frames.back().data; }

  Line line;
  CanopenSdo sdo{kNode, kTimeout, kTries};
  Time now = Time{} + duration(100);
};

TEST_F(Client, ReadsExpedited) {
  EXPECT_EQ(sdo.status(), Status::kIdle);
  sdo.startUpload({0x6064, 0});
  EXPECT_TRUE(line.frames.empty());
  update();
  ASSERT_EQ(line.frames.size(), 1u);
  EXPECT_EQ(line.frames[0].id, 0x603u);
  EXPECT_EQ(lastSent(), (Bytes{0x40, 0x64, 0x60, 0x00}));
  EXPECT_TRUE(sdo.take(makeReply({0x43, 0x64, 0x60, 0x00, 0xFE, 0xFF, 0xFF, 0xFF})));
  EXPECT_EQ(sdo.status(), Status::kDone);
  EXPECT_EQ(sdo.signedValue(), -2);
  EXPECT_EQ(sdo.value(), 0xFFFFFFFEu);
  update(1);
  EXPECT_EQ(line.frames.size(), 1u);
}

TEST_F(Client, WritesExpedited) {
  sdo.startDownload({0x6040, 0}, 0x0F, 2);
  update();
  EXPECT_EQ(lastSent(), (Bytes{0x2B, 0x40, 0x60, 0x00, 0x0F}));
  EXPECT_TRUE(sdo.take(makeReply({0x60, 0x40, 0x60, 0x00})));
  EXPECT_EQ(sdo.status(), Status::kDone);
}

TEST_F(Client, TellsWhatTheServerRefuses) {
  sdo.startDownload({0x1A00, 1}, 0x60640020, 4);
  update();
  sdo.take(makeReply({0x80, 0x00, 0x1A, 0x01, 0x41, 0x00, 0x04, 0x06}));
  EXPECT_EQ(sdo.status(), Status::kAborted);
  EXPECT_EQ(sdo.abortCode(), 0x06040041u);
}

TEST_F(Client, RepeatsAndGivesUp) {
  sdo.startUpload({0x6064, 0});
  for (int i = 0; i < 50; ++i) update(0.01);
  EXPECT_EQ(sdo.status(), Status::kSilent);
  ASSERT_EQ(line.frames.size(), kTries + 1u);
  EXPECT_EQ(lastSent(), (Bytes{0x80, 0x64, 0x60, 0x00, 0x00, 0x00, 0x04, 0x05}));
}

TEST_F(Client, AnswerToTheSecondAskingCounts) {
  sdo.startUpload({0x6064, 0});
  update();
  update(0.2);
  sdo.take(makeReply({0x43, 0x64, 0x60, 0x00, 0x05}));
  EXPECT_EQ(sdo.value(), 5u);
  sdo.take(makeReply({0x43, 0x64, 0x60, 0x00, 0x06}));
  EXPECT_EQ(sdo.value(), 5u);
  EXPECT_EQ(sdo.stale(), 1u);
}

TEST_F(Client, AnswersToSomethingElseDoNotCount) {
  sdo.startUpload({0x6064, 0});
  sdo.take(makeReply({0x43, 0x64, 0x60, 0x00, 0x05}));  // before it was asked
  update();
  sdo.take(makeReply({0x43, 0x64, 0x60, 0x01, 0x05}));  // another subindex
  sdo.take(makeReply({0x60, 0x64, 0x60, 0x00}));        // as if written
  sdo.take(makeReply({0x01, 1, 2, 3}));                 // a segment
  sdo.take(makeReply({0x80, 0x40, 0x60, 0x00, 0x00, 0x00, 0x02, 0x06}));
  EXPECT_EQ(sdo.status(), Status::kBusy);
  EXPECT_EQ(sdo.stale(), 5u);
  EXPECT_FALSE(sdo.take(makeReply({0x43, 0x64, 0x60, 0x00, 0x05}, kNode + 1)));
  sdo.take(makeReply({0xC0}));
  EXPECT_EQ(sdo.malformed(), 1u);
  EXPECT_EQ(sdo.status(), Status::kBusy);
}

TEST_F(Client, ReadsInSegments) {
  sdo.startUpload({0x1008, 0});
  update();
  sdo.take(makeReply({0x41, 0x08, 0x10, 0x00, 10}));
  update();
  EXPECT_EQ(lastSent(), (Bytes{0x60}));
  sdo.take(makeReply({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}));
  update();
  EXPECT_EQ(lastSent(), (Bytes{0x70}));
  sdo.take(makeReply({0x19, 'h', 'i', 'j'}));
  EXPECT_EQ(sdo.status(), Status::kDone);
  EXPECT_EQ(std::string(sdo.data(), sdo.data() + sdo.size()), "abcdefghij");
}

TEST_F(Client, ADoubledSegmentCountsOnce) {
  sdo.startUpload({0x1008, 0});
  update();
  sdo.take(makeReply({0x41, 0x08, 0x10, 0x00, 10}));
  update();
  const CanFrame first = makeReply({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'});
  sdo.take(first);
  update();
  sdo.take(first);
  EXPECT_EQ(sdo.status(), Status::kBusy);
  sdo.take(makeReply({0x19, 'h', 'i', 'j'}));
  EXPECT_EQ(std::string(sdo.data(), sdo.data() + sdo.size()), "abcdefghij");
}

TEST_F(Client, AbortsWhereTheToggleBitStays) {
  sdo.startUpload({0x1008, 0});
  update();
  sdo.take(makeReply({0x41, 0x08, 0x10, 0x00, 10}));
  update();
  sdo.take(makeReply({0x10, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}));
  EXPECT_EQ(sdo.status(), Status::kAborted);
  update();
  EXPECT_EQ(lastSent(), (Bytes{0x80, 0x08, 0x10, 0x00, 0x00, 0x00, 0x03, 0x05}));
}

TEST_F(Client, AbortsWhatIsLongerThanItCanHold) {
  sdo.startUpload({0x1008, 0});
  update();
  sdo.take(makeReply({0x41, 0x08, 0x10, 0x00, 0xFF, 0xFF, 0xFF, 0xFF}));
  EXPECT_EQ(sdo.abortCode(), 0x05040005u);

  sdo.startUpload({0x1008, 0});  // and what goes on without end
  update();
  sdo.take(makeReply({0x40, 0x08, 0x10, 0x00}));
  for (int i = 0; i < 20 && sdo.status() == Status::kBusy; ++i) {
    update();
    sdo.take(makeReply({static_cast<std::uint8_t>(i % 2 == 0 ? 0x00 : 0x10), 'x', static_cast<std::uint8_t>(i)}));
  }
  EXPECT_EQ(sdo.status(), Status::kAborted);
  EXPECT_EQ(sdo.abortCode(), 0x05040005u);
}

TEST_F(Client, AbortsWhatIsNotAsLongAsAnnounced) {
  for (const std::uint8_t announced : {std::uint8_t{6}, std::uint8_t{8}}) {
    sdo.startUpload({0x1008, 0});
    update();
    sdo.take(makeReply({0x41, 0x08, 0x10, 0x00, announced}));
    update();
    sdo.take(makeReply({0x01, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}));
    EXPECT_EQ(sdo.abortCode(), 0x06070010u);
  }
}

TEST_F(Client, BeginsASegmentedTransferAnew) {
  sdo.startUpload({0x1008, 0});
  update();
  sdo.take(makeReply({0x41, 0x08, 0x10, 0x00, 10}));
  update();
  sdo.take(makeReply({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}));
  update();
  update(0.2);  // the second segment is lost
  ASSERT_GE(line.frames.size(), 2u);
  EXPECT_EQ(line.frames[line.frames.size() - 2].data[0], 0x80);
  EXPECT_EQ(lastSent(), (Bytes{0x40, 0x08, 0x10, 0x00}));
  sdo.take(makeReply({0x4F, 0x08, 0x10, 0x00, 'z'}));
  EXPECT_EQ(sdo.status(), Status::kDone);
  EXPECT_EQ(sdo.size(), 1u);
}

// Against a server that knows how, over a line that loses and doubles.
TEST_F(Client, TransfersAnyLengthOverABadLine) {
  SimulatedObjectDictionary dictionary;
  dictionary.addText(0x2010, "", 64);
  SimulatedSdoServer server(kNode, dictionary);
  std::mt19937 random(5);
  std::uniform_int_distribution<int> byte(0, 255), luck(0, 99);
  CanopenSdo client(kNode, kTimeout, 40);
  const auto run = [&] {
    for (int i = 0; i < 5000 && client.status() == Status::kBusy; ++i) {
      now += duration(0.02);
      line.frames.clear();
      client.update(now, line);
      for (const CanFrame& request : line.frames) {
        CanFrame reply;
        if (luck(random) < 3 || !server.serve(request, reply)) continue;
        const int l = luck(random);
        if (l >= 3) client.take(reply);
        if (l >= 80) client.take(reply);
      }
    }
  };
  for (std::size_t size = 1; size <= CanopenSdo::kCapacity; ++size) {
    std::vector<std::uint8_t> data(size);
    for (std::uint8_t& b : data) b = static_cast<std::uint8_t>(byte(random));
    client.startDownload({0x2010, 0}, data.data(), data.size());
    run();
    ASSERT_EQ(client.status(), Status::kDone) << size;
    client.startUpload({0x2010, 0});
    run();
    ASSERT_EQ(client.status(), Status::kDone) << size;
    ASSERT_EQ(std::vector<std::uint8_t>(client.data(), client.data() + client.size()), data);
  }
}

// Whatever a server says, every transfer ends, and says no more than so many frames.
TEST_F(Client, EndsWhateverTheServerSays) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255);
  const std::uint8_t commands[] = {0x40, 0x41, 0x43, 0x4F, 0x60, 0x20, 0x30, 0x00, 0x10, 0x01, 0x80, 0xA0};
  for (int trial = 0; trial < 2000; ++trial) {
    const std::uint8_t data[CanopenSdo::kCapacity] = {};
    if (trial % 2 == 0)
      sdo.startUpload({0x1008, 0});
    else
      sdo.startDownload({0x1008, 0}, data, 1 + static_cast<std::size_t>(trial) % CanopenSdo::kCapacity);
    line.frames.clear();
    for (int i = 0; i < 60; ++i) {
      update(0.02);
      Bytes reply{commands[static_cast<std::size_t>(byte(random)) % sizeof commands], 0x08, 0x10, 0x00};
      for (std::size_t b = 4; b < 8; ++b) reply[b] = static_cast<std::uint8_t>(byte(random) % 20);
      sdo.take(makeReply(reply));
      ASSERT_LE(sdo.size(), CanopenSdo::kCapacity);
    }
    for (int i = 0; i < 20; ++i) update(0.11);  // it falls silent
    EXPECT_NE(sdo.status(), Status::kBusy);
    EXPECT_LE(line.frames.size(), 70u);
  }
}

}  // namespace
}  // namespace sinew
