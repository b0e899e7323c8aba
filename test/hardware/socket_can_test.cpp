#include "sinew/hardware/socket_can.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <thread>

#include "hardware/can_frames.h"
#include "sinew/hardware/can_device_bus.h"
#include "sinew/hardware/canopen_drive.h"
#include "sinew/hardware/odrive_axis.h"
#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/simulated_can_bus.h"
#include "sinew/hardware/simulated_cia402_drive.h"
#include "sinew/hardware/simulated_odrive.h"

namespace sinew {
namespace {

constexpr const char* kInterface = "vcan0";
constexpr auto kLong = std::chrono::seconds(10);
constexpr int kSlcanDiscipline = 17;  // N_SLCAN

TEST(SocketCan, SaysWhyItCannotOpen) {
  SocketCan port;
  for (const char* name : {"", "no_such_can0", "a_name_that_is_too_long", "lo"}) {
    EXPECT_FALSE(port.open(name));
    EXPECT_FALSE(port.isOpen());
    EXPECT_FALSE(port.error().empty());
  }
  CanFrame frame;
  EXPECT_EQ(port.send(frame, Duration{0}), StreamStatus::kClosed);
  EXPECT_EQ(port.receive(frame, Duration{0}), StreamStatus::kClosed);
}

// The rest needs a virtual CAN interface and the right to switch it: scripts/can_guest has both.
class VirtualCan : public testing::Test {
 protected:
  void SetUp() override {
    if (if_nametoindex(kInterface) == 0) GTEST_SKIP() << "no interface " << kInterface << "; run scripts/can_guest";
    setUp(kInterface, true);
  }

  static bool setUp(const char* interface, bool up) {
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    ifreq request{};
    std::strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
    const bool found = ioctl(fd, SIOCGIFFLAGS, &request) == 0;
    const int flags = up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP;
    request.ifr_flags = static_cast<short>(flags);
    const bool done = found && ioctl(fd, SIOCSIFFLAGS, &request) == 0;
    ::close(fd);
    return done;
  }
};

TEST_F(VirtualCan, CarriesEveryFrameAndNotItsOwn) {
  SocketCan a, b;
  ASSERT_TRUE(a.open(kInterface)) << a.error();
  ASSERT_TRUE(b.open(kInterface)) << b.error();
  std::mt19937 random(7);
  CanFrame got;
  for (int n = 0; n < 2000; ++n) {
    const CanFrame sent = makeRandomFrame(random);
    ASSERT_EQ(a.send(sent, kLong), StreamStatus::kOk);
    ASSERT_EQ(b.receive(got, kLong), StreamStatus::kOk);
    ASSERT_TRUE(got == sent) << n;
  }
  EXPECT_EQ(a.receive(got, Duration{0}), StreamStatus::kTimeout) << "its own frames";
  const Time start = Clock::now();
  EXPECT_EQ(b.receive(got, std::chrono::milliseconds(20)), StreamStatus::kTimeout);
  EXPECT_GE(Clock::now() - start, std::chrono::milliseconds(19));
}

TEST_F(VirtualCan, SaysWhenTheInterfaceIsDown) {
  SocketCan port;
  ASSERT_TRUE(setUp(kInterface, false));
  EXPECT_FALSE(port.open(kInterface));
  EXPECT_NE(port.error().find("vcan0 is down; as root: ip link set vcan0 up"), std::string::npos) << port.error();
  EXPECT_FALSE(port.open("lo"));
  EXPECT_NE(port.error().find("no CAN interface"), std::string::npos) << port.error();
  EXPECT_FALSE(port.open("vcan99"));
  EXPECT_NE(port.error().find("no interface vcan99"), std::string::npos) << port.error();
  ASSERT_TRUE(setUp(kInterface, true));
  EXPECT_TRUE(port.open(kInterface)) << port.error();
}

TEST_F(VirtualCan, NoticesThatTheInterfaceGoesDown) {
  SocketCan receiver, sender;
  ASSERT_TRUE(receiver.open(kInterface) && sender.open(kInterface));
  std::thread admin([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    setUp(kInterface, false);
  });
  CanFrame frame;
  EXPECT_EQ(receiver.receive(frame, kLong), StreamStatus::kClosed);
  admin.join();
  EXPECT_EQ(sender.send(frame, kLong), StreamStatus::kClosed);
  EXPECT_FALSE(receiver.isOpen() || sender.isOpen());
  EXPECT_FALSE(receiver.error().empty());
  setUp(kInterface, true);
  ASSERT_TRUE(receiver.open(kInterface) && sender.open(kInterface));
  EXPECT_EQ(sender.send(makeFrame(0x123, {1}), kLong), StreamStatus::kOk);
  EXPECT_EQ(receiver.receive(frame, kLong), StreamStatus::kOk);
}

// Error frames as a controller's driver makes them.
TEST_F(VirtualCan, ReadsErrorFrames) {
  SocketCan port;
  ASSERT_TRUE(port.open(kInterface));
  const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(kInterface));
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const auto tell = [fd](std::uint32_t error, std::uint8_t detail) {
    can_frame frame{};
    frame.can_id = CAN_ERR_FLAG | error;
    frame.can_dlc = CAN_ERR_DLC;
    frame.data[1] = detail;
    return write(fd, &frame, sizeof frame) == static_cast<ssize_t>(sizeof frame);
  };
  ASSERT_TRUE(tell(CAN_ERR_ACK, 0) && tell(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING) &&
              tell(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW));
  CanFrame frame;
  EXPECT_EQ(port.receive(frame, std::chrono::milliseconds(50)), StreamStatus::kTimeout);
  EXPECT_EQ(port.errors().unacknowledged, 1u);
  EXPECT_EQ(port.errors().warnings, 1u);
  EXPECT_EQ(port.errors().lost, 1u);
  ASSERT_TRUE(tell(CAN_ERR_BUSOFF, 0));
  EXPECT_EQ(port.receive(frame, kLong), StreamStatus::kClosed);
  EXPECT_NE(port.error().find("off the bus"), std::string::npos) << port.error();
  ::close(fd);
}

// The kernel's own SLCAN driver takes the simulated adapter for a real one.
TEST_F(VirtualCan, TheKernelDrivesTheSimulatedAdapter) {
  PseudoTerminal terminal;
  std::vector<SimulatedCanBus::Member> members;
  SimulatedOdrive::Parameters parameters;
  parameters.watchdog_enabled = false;
  members.push_back({std::make_unique<SimulatedOdrive>(1, parameters), {0}});
  SimulatedCanBus bus(std::move(members), 1000000);
  bus.start(terminal);
  const int tty = ::open(terminal.path().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(tty, 0);
  const char commands[] = "S8\rO\r";
  char answers[2] = {};
  ASSERT_EQ(::write(tty, commands, sizeof commands - 1), static_cast<ssize_t>(sizeof commands - 1));
  for (char& a : answers) {
    while (::read(tty, &a, 1) != 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(std::string(answers, 2), "\r\r");
  ASSERT_EQ(ioctl(tty, TIOCSETD, &kSlcanDiscipline), 0) << std::strerror(errno) << ": is the module slcan there?";
  char name[IFNAMSIZ] = {};
  ASSERT_EQ(ioctl(tty, SIOCGIFNAME, name), 0);
  ASSERT_TRUE(setUp(name, true)) << name;
  SocketCan port;
  ASSERT_TRUE(port.open(name)) << port.error();
  CanFrame frame;
  ASSERT_EQ(port.receive(frame, kLong), StreamStatus::kOk);
  EXPECT_EQ(frame.id, 0x021u) << "a heartbeat";
  ASSERT_EQ(port.send(makeRemote(0x029, 0), kLong), StreamStatus::kOk);
  do ASSERT_EQ(port.receive(frame, kLong), StreamStatus::kOk);
  while (frame.id != 0x029);
  EXPECT_EQ(frame.size, 8);
  constexpr int kNoDiscipline = 0;  // N_TTY
  ASSERT_EQ(ioctl(tty, TIOCSETD, &kNoDiscipline), 0);
  StreamStatus status = StreamStatus::kOk;
  while (status == StreamStatus::kOk) status = port.receive(frame, kLong);
  EXPECT_EQ(status, StreamStatus::kClosed) << "unplugged";
  ::close(tty);
  bus.stop();
}

TEST_F(VirtualCan, ABusOfBothKindsOfDriveIsSetUpFollowsAndStopsByItself) {
  constexpr double kPeriod = 0.02, kWatchdog = 0.5, kRadius = 0.01;
  constexpr int kDrives = 4, kOdrives = 2;
  std::vector<SimulatedCanBus::Member> simulated;
  std::vector<CanDeviceBus::Member> members;
  const DeviceTiming timing{kPeriod, kWatchdog, 0.02, 20};
  WinchDescription cable;
  cable.spool_radius = kRadius;
  cable.torque_constant = 0.5;
  cable.tension_max = 20;
  for (int i = 0; i < kDrives; ++i) {
    const ActuatorBounds bounds{"cable_" + std::to_string(i), -0.1, 0.1, 0.1};
    if (i < kOdrives) {
      SimulatedOdrive::Parameters parameters;
      parameters.watchdog_timeout = kWatchdog;
      OdriveSettings settings;
      settings.node = i + 1;
      simulated.push_back({std::make_unique<SimulatedOdrive>(i + 1, parameters), {i}});
      members.push_back({std::make_unique<OdriveAxis>(settings, cable, bounds, timing), {i}});
    } else {
      CanopenSettings settings;
      settings.node = static_cast<std::uint8_t>(31 + i);
      settings.driver_node = 127;
      settings.counts_per_turn = 4096;
      settings.gear = 10;
      settings.rated_unit = 1e-3;
      settings.heartbeat = 0.1;
      simulated.push_back(
          {std::make_unique<SimulatedCia402Drive>(settings.node, SimulatedCia402Drive::Parameters()), {i}});
      members.push_back({std::make_unique<CanopenDrive>(settings, cable, bounds, timing), {i}});
    }
  }
  SocketCan devices_side;
  ASSERT_TRUE(devices_side.open(kInterface));
  SimulatedCanBus line(std::move(simulated), 1000000);
  line.start(devices_side);
  CanDeviceBus bus(
      [](std::string& why) -> std::shared_ptr<CanPort> {
        auto port = std::make_shared<SocketCan>();
        const bool open = port->open(kInterface);
        why = port->error();
        return open ? port : nullptr;
      },
      std::move(members), timing);
  std::string why;
  ASSERT_TRUE(bus.open(why)) << why;
  const auto pass = [&line] {
    line.step(kPeriod);
    std::this_thread::sleep_for(duration(kPeriod));
  };
  bus.startSetUp(false);
  SetUpProgress progress = SetUpProgress::kBusy;
  for (int n = 0; n < 500 && progress == SetUpProgress::kBusy; ++n) {
    progress = bus.updateSetUp(Clock::now());
    pass();
  }
  ASSERT_EQ(progress, SetUpProgress::kDone) << bus.problem();
  for (int i = 0; i < kDrives; ++i) {
    bus.setZero(i, 0);
    EXPECT_NEAR(line.shaftAngle(i), 0, 1e-6) << "nothing has moved";
  }
  const double set_points[] = {0.01, -0.005, 0.01, -0.005};
  for (int n = 0; n < 50; ++n) {
    ASSERT_TRUE(bus.writeSetPoints(set_points, Clock::now()) && bus.read(Clock::now()));
    pass();
  }
  for (int i = 0; i < kDrives; ++i) {
    EXPECT_NEAR(kRadius * line.shaftAngle(i), set_points[i], 1e-5);
    EXPECT_NEAR(bus.readings()[static_cast<std::size_t>(i)].measured, set_points[i], 1e-5);
    EXPECT_EQ(bus.readings()[static_cast<std::size_t>(i)].fault, 0u) << bus.faultDetail(i);
    EXPECT_TRUE(line.energised(i));
  }
  std::this_thread::sleep_for(duration(2 * kWatchdog));
  for (int i = 0; i < kOdrives; ++i) EXPECT_FALSE(line.energised(i)) << "nobody has spoken to it";
  ASSERT_TRUE(bus.read(Clock::now()));
  for (int n = 0; n < 20; ++n) {
    bus.writeSetPoints(set_points, Clock::now());
    bus.read(Clock::now());
    pass();
  }
  for (const ActuatorReading& r : bus.readings()) EXPECT_NE(r.fault, 0u);
  line.stop();
}

}  // namespace
}  // namespace sinew
