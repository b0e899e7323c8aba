#include "sinew/hardware/serial_port.h"

#include <asm/termbits.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <memory>

#include "sinew/common/config_error.h"
#include "sinew/hardware/pseudo_terminal.h"

namespace sinew {
namespace {

constexpr auto kLong = std::chrono::seconds(5);

TEST(SerialPort, SaysWhyItCannotOpen) {
  SerialPort port;
  EXPECT_FALSE(port.open("/dev/no_such_port", 57600));
  EXPECT_NE(port.error().find("/dev/no_such_port"), std::string::npos);
  EXPECT_FALSE(port.isOpen());
  std::uint8_t byte = 0;
  EXPECT_EQ(port.read(&byte, 1, Duration{0}).status, StreamStatus::kClosed);
  EXPECT_EQ(port.write(&byte, 1, Duration{0}).status, StreamStatus::kClosed);
  EXPECT_FALSE(port.open("/dev/null", 57600)) << "not a terminal";
}

TEST(SerialPort, TakesEveryBaudRate) {
  PseudoTerminal terminal;
  for (const int baud : {9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000, 4500000, 123456}) {
    SerialPort port;
    ASSERT_TRUE(port.open(terminal.path(), baud)) << baud << ": " << port.error();
    EXPECT_FALSE(port.lowLatency()) << "a pseudo-terminal has no such flag, and that is no error";
    const int fd = ::open(terminal.path().c_str(), O_RDWR | O_NOCTTY);
    if (fd < 0) continue;  // exclusive ports let only the superuser look
    termios2 settings{};
    ASSERT_EQ(ioctl(fd, TCGETS2, &settings), 0);
    EXPECT_EQ(static_cast<int>(settings.c_ospeed), baud);
    ::close(fd);
  }
}

TEST(SerialPort, CarriesEveryByteBothWays) {
  PseudoTerminal terminal;
  SerialPort port;
  ASSERT_TRUE(port.open(terminal.path(), 1000000));
  std::uint8_t out[256], in[256];
  for (int i = 0; i < 256; ++i) out[i] = static_cast<std::uint8_t>(i);
  for (const bool to_device : {true, false}) {
    ByteStream& from = to_device ? static_cast<ByteStream&>(port) : terminal;
    ByteStream& to = to_device ? static_cast<ByteStream&>(terminal) : port;
    ASSERT_EQ(from.write(out, sizeof out, kLong).count, sizeof out);
    std::size_t got = 0;
    while (got < sizeof in) {
      const StreamResult r = to.read(in + got, sizeof in - got, kLong);
      ASSERT_EQ(r.status, StreamStatus::kOk);
      got += r.count;
    }
    for (int i = 0; i < 256; ++i) ASSERT_EQ(in[i], out[i]) << to_device;
  }
}

TEST(SerialPort, ReadWaitsNoLongerThanTold) {
  PseudoTerminal terminal;
  SerialPort port;
  ASSERT_TRUE(port.open(terminal.path(), 1000000));
  std::uint8_t byte = 0;
  const Time start = Clock::now();
  EXPECT_EQ(port.read(&byte, 1, std::chrono::milliseconds(20)).status, StreamStatus::kTimeout);
  EXPECT_GE(Clock::now() - start, std::chrono::milliseconds(19));
  EXPECT_EQ(port.read(&byte, 1, Duration{0}).status, StreamStatus::kTimeout);
}

TEST(SerialPort, WriteGivesUpWhenNobodyReads) {
  PseudoTerminal terminal;
  SerialPort port;
  ASSERT_TRUE(port.open(terminal.path(), 1000000));
  const std::vector<std::uint8_t> much(1 << 20, 0x55);
  const StreamResult result = port.write(much.data(), much.size(), std::chrono::milliseconds(20));
  EXPECT_EQ(result.status, StreamStatus::kTimeout);
  EXPECT_LT(result.count, much.size());
}

TEST(SerialPort, NoticesThatTheDeviceIsGone) {
  auto terminal = std::make_unique<PseudoTerminal>();
  SerialPort port;
  ASSERT_TRUE(port.open(terminal->path(), 1000000));
  terminal.reset();
  std::uint8_t byte = 0;
  EXPECT_EQ(port.read(&byte, 1, kLong).status, StreamStatus::kClosed);
  EXPECT_FALSE(port.isOpen());
}

TEST(SerialPort, TellsPseudoTerminalsFromDevices) {
  const std::string link = testing::TempDir() + "sinew_serial_port_test_" + std::to_string(getpid());
  PseudoTerminal terminal(link);
  EXPECT_TRUE(isPseudoTerminal(terminal.path()));
  EXPECT_TRUE(isPseudoTerminal(link)) << "through a link";
  EXPECT_FALSE(isPseudoTerminal("/dev/null"));
  EXPECT_FALSE(isPseudoTerminal("/dev/ttyUSB0"));
}

TEST(PseudoTerminal, DriverMayComeAndGo) {
  PseudoTerminal terminal;
  std::uint8_t byte = 7;
  for (int n = 0; n < 3; ++n) {
    SerialPort port;
    ASSERT_TRUE(port.open(terminal.path(), 1000000)) << port.error();
    ASSERT_EQ(port.write(&byte, 1, kLong).status, StreamStatus::kOk);
    ASSERT_EQ(terminal.read(&byte, 1, kLong).status, StreamStatus::kOk);
    port.close();
    EXPECT_EQ(terminal.read(&byte, 1, Duration{0}).status, StreamStatus::kTimeout);
  }
}

TEST(PseudoTerminal, LinkAppearsAndGoes) {
  const std::string link = testing::TempDir() + "sinew_pseudo_terminal_test_" + std::to_string(getpid());
  {
    PseudoTerminal terminal(link);
    PseudoTerminal second(link);  // takes the link over
    SerialPort port;
    EXPECT_TRUE(port.open(link, 57600)) << port.error();
  }
  EXPECT_NE(access(link.c_str(), F_OK), 0);
  EXPECT_THROW(PseudoTerminal("/no_such_folder/link"), ConfigError);
}

}  // namespace
}  // namespace sinew
