#include "sinew/hardware/slcan_port.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "hardware/can_frames.h"
#include "hardware/memory_stream.h"
#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/serial_port.h"
#include "sinew/hardware/simulated_slcan_adapter.h"

namespace sinew {
namespace {

constexpr auto kLong = std::chrono::seconds(5);

// Answers every command of a script with the text that belongs to it; what is not in the script stays unanswered.
class ScriptedAdapter : public MemoryStream {
 public:
  using Script = std::vector<std::pair<std::string, std::string>>;
  explicit ScriptedAdapter(Script script) : script_(std::move(script)) {}
  StreamResult write(const std::uint8_t* data, std::size_t size, Duration timeout) override {
    const std::string command(reinterpret_cast<const char*>(data), size);
    for (const auto& line : script_)
      if (line.first == command) answerNextWrite(Bytes(line.second.begin(), line.second.end()));
    return MemoryStream::write(data, size, timeout);
  }
  std::string written() {
    const Bytes bytes = takeWritten();
    return std::string(bytes.begin(), bytes.end());
  }

 private:
  Script script_;
};

TEST(SlcanPort, OpensTheChannelAtItsBitRate) {
  const auto line =
      std::make_shared<ScriptedAdapter>(ScriptedAdapter::Script{{"\rC\r", "\r\a"}, {"S8\r", "\r"}, {"O\r", "\r"}});
  SlcanPort port;
  ASSERT_TRUE(port.open(line, 1000000)) << port.error();
  EXPECT_EQ(line->written(), "\rC\rS8\rO\r");
  port.close();
  EXPECT_EQ(line->written(), "C\r");
  EXPECT_FALSE(port.isOpen());
}

TEST(SlcanPort, IgnoresTheTrafficOfAnEarlierUser) {
  const auto line = std::make_shared<ScriptedAdapter>(
      ScriptedAdapter::Script{{"\rC\r", "t1232AABB\rt12"}, {"S6\r", "\r"}, {"O\r", "\rt1230\r"}});
  const std::string left = "t1230\rT000001230\r\r";
  line->arrive(MemoryStream::Bytes(left.begin(), left.end()));
  SlcanPort port;
  ASSERT_TRUE(port.open(line, 500000)) << port.error();
  CanFrame frame;
  ASSERT_EQ(port.receive(frame, Duration{0}), StreamStatus::kOk);
  EXPECT_EQ(frame.id, 0x123u);
}

TEST(SlcanPort, SaysWhatIsWrong) {
  SlcanPort port;
  const auto expect = [&port](ScriptedAdapter::Script script, int bitrate, const std::string& why) {
    EXPECT_FALSE(port.open(std::make_shared<ScriptedAdapter>(std::move(script)), bitrate));
    EXPECT_NE(port.error().find(why), std::string::npos) << port.error();
    EXPECT_FALSE(port.isOpen());
  };
  expect({}, 123456, "bit rate 123456");
  expect({}, 500000, "nobody answers");
  expect({{"\rC\r", "\r"}, {"S6\r", "\a"}}, 500000, "refuses bit rate 500000");
  expect({{"\rC\r", "\r"}, {"S6\r", "\r"}, {"O\r", "\a"}}, 500000, "does not open");
  CanFrame frame;
  EXPECT_EQ(port.send(frame, Duration{0}), StreamStatus::kClosed);
  EXPECT_EQ(port.receive(frame, Duration{0}), StreamStatus::kClosed);
}

TEST(SlcanPort, CountsWhatTheAdapterRefusesAndWhatIsDamaged) {
  const auto line =
      std::make_shared<ScriptedAdapter>(ScriptedAdapter::Script{{"\rC\r", "\r"}, {"S6\r", "\r"}, {"O\r", "\r"}});
  SlcanPort port;
  ASSERT_TRUE(port.open(line, 500000)) << port.error();
  const std::string text = "z\r\at12\rt4561AB\r";
  line->arrive(MemoryStream::Bytes(text.begin(), text.end()));
  CanFrame frame;
  ASSERT_EQ(port.receive(frame, Duration{0}), StreamStatus::kOk);
  EXPECT_TRUE(frame == makeFrame(0x456, {0xAB}));
  EXPECT_EQ(port.damaged(), 2u);
  EXPECT_EQ(port.receive(frame, std::chrono::milliseconds(3)), StreamStatus::kTimeout);
}

TEST(SlcanPort, CarriesEveryFrameBothWaysOverATerminal) {
  auto terminal = std::make_unique<PseudoTerminal>();
  SimulatedSlcanAdapter adapter(*terminal);
  std::atomic<bool> running{true};
  std::thread echo([&] {  // every frame comes back with its identifier's lowest bit turned
    CanFrame frame;
    while (running)
      if (adapter.receive(frame, std::chrono::milliseconds(5)) == StreamStatus::kOk) {
        frame.id ^= 1;
        adapter.send(frame, kLong);
      }
  });
  const auto serial = std::make_shared<SerialPort>();
  SlcanPort port;
  ASSERT_TRUE(serial->open(terminal->path(), 1000000)) << serial->error();
  ASSERT_TRUE(port.open(serial, 250000, std::chrono::milliseconds(500))) << port.error();
  EXPECT_EQ(adapter.bitrateDigit(), 5);
  std::mt19937 random(3);
  for (int n = 0; n < 500; ++n) {
    const CanFrame sent = makeRandomFrame(random);
    CanFrame got;
    ASSERT_EQ(port.send(sent, kLong), StreamStatus::kOk);
    ASSERT_EQ(port.receive(got, kLong), StreamStatus::kOk);
    got.id ^= 1;
    ASSERT_TRUE(got == sent) << n;
  }
  EXPECT_EQ(port.damaged(), 0u);
  running = false;
  echo.join();
  terminal.reset();
  CanFrame frame;
  EXPECT_EQ(port.receive(frame, kLong), StreamStatus::kClosed) << "unplugged";
  EXPECT_FALSE(port.isOpen());
}

}  // namespace
}  // namespace sinew
