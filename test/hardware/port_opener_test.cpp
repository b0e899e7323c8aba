#include "sinew/hardware/port_opener.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/simulated_slcan_adapter.h"

namespace sinew {
namespace {

BusDescription describe(BusType type, const std::string& port) {
  BusDescription bus;
  bus.type = type;
  bus.port = port;
  bus.baud = 115200;
  bus.bitrate = 500000;
  return bus;
}

TEST(PortOpener, OpensASerialPort) {
  PseudoTerminal device;
  std::string why;
  const auto port = makePortOpener().serial(describe(BusType::kDynamixel, device.path()), why);
  ASSERT_NE(port, nullptr) << why;
  const std::uint8_t sent = 42;
  ASSERT_EQ(device.write(&sent, 1, std::chrono::seconds(5)).count, 1u);
  std::uint8_t received = 0;
  EXPECT_EQ(port->read(&received, 1, std::chrono::seconds(5)).count, 1u);
  EXPECT_EQ(received, sent);
}

TEST(PortOpener, OpensACanBusBehindASerialAdapter) {
  PseudoTerminal line;
  SimulatedSlcanAdapter adapter(line);
  std::atomic<bool> running{true};
  std::thread thread([&] {
    CanFrame frame;
    while (running) adapter.receive(frame, std::chrono::milliseconds(5));
  });
  std::string why;
  const auto port = makePortOpener().can(describe(BusType::kCan, line.path()), why);
  running = false;
  thread.join();
  ASSERT_NE(port, nullptr) << why;
  EXPECT_EQ(adapter.bitrateDigit(), 6) << "500 kbit/s";
}

TEST(PortOpener, SaysWhyItCannot) {
  const LineOpener opener = makePortOpener();
  std::string why;
  EXPECT_EQ(opener.serial(describe(BusType::kPressureBoard, "/dev/nowhere"), why), nullptr);
  EXPECT_NE(why.find("/dev/nowhere"), std::string::npos);
  why.clear();
  EXPECT_EQ(opener.can(describe(BusType::kCan, "/dev/nowhere"), why), nullptr);
  EXPECT_NE(why.find("/dev/nowhere"), std::string::npos);
  why.clear();
  EXPECT_EQ(opener.can(describe(BusType::kCan, "nocan7"), why), nullptr) << "an interface of the kernel";
  EXPECT_FALSE(why.empty());
}

}  // namespace
}  // namespace sinew
