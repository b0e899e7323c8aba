#include "sinew/hardware/simulated_can_bus.h"

#include <gtest/gtest.h>

#include <deque>

#include "hardware/can_frames.h"
#include "sinew/common/config_error.h"
#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/serial_port.h"
#include "sinew/hardware/simulated_can_port.h"
#include "sinew/hardware/slcan_port.h"

namespace sinew {
namespace {

// Answers a remote frame to its identifier by a data frame that carries how many it has seen.
class EchoNode : public SimulatedCanNode {
 public:
  EchoNode(std::uint32_t id, Duration beat) : id_(id), beat_(beat) {}
  int size() const override { return 1; }
  void take(const CanFrame& frame, Time now, std::vector<CanFrame>& out) override {
    taken_at = now;
    if (frame.remote && frame.id == id_) out.push_back(makeFrame(id_, {count_++}));
  }
  void update(Time now, std::vector<CanFrame>& out) override {
    if (beat_ == Duration{0} || now < next_) return;
    next_ = now + beat_;
    out.push_back(makeFrame(id_ + 1, {}));
  }
  void step(double dt) override { angle_ += load_ * dt; }
  void setLoadTorque(int, double torque) override { load_ = torque; }
  double shaftAngle(int) const override { return angle_; }
  double pressure(int) const override { return 0; }
  bool energised(int) const override { return true; }
  void setFrozen(bool) override {}
  void setTemperature(double) override {}
  void setSupplyVoltage(double) override {}
  void powerCycle() override { angle_ = 0; }
  void setLeak(int, double) override {}

  Time taken_at{};

 private:
  std::uint32_t id_;
  Duration beat_;
  Time next_{};
  int count_ = 0;
  double angle_ = 0, load_ = 0;
};

constexpr int kBitrate = 500000;

std::unique_ptr<SimulatedCanBus> makeBus(const std::vector<std::uint32_t>& ids, Duration beat = Duration{0}) {
  std::vector<SimulatedCanBus::Member> members;
  for (std::size_t i = 0; i < ids.size(); ++i)
    members.push_back({std::make_unique<EchoNode>(ids[i], beat), {static_cast<int>(i)}});
  return std::make_unique<SimulatedCanBus>(std::move(members), kBitrate);
}

// ISO 11898-1: 44 bits and 8 a byte, 3 of pause, and one stuff bit a quarter of what is stuffed at the most.
TEST(SimulatedCanBus, FramesTakeTheirTime) {
  EXPECT_NEAR(calcFrameTime(makeFrame(1, {1, 2, 3, 4, 5, 6, 7, 8}), 1000000), 135e-6, 1e-12);
  EXPECT_NEAR(calcFrameTime(makeFrame(1, {}), 500000), 2 * 55e-6, 1e-12);
  EXPECT_NEAR(calcFrameTime(makeRemote(1, 8), 500000), 2 * 55e-6, 1e-12);
  EXPECT_NEAR(calcFrameTime(makeExtended(1, {1, 2, 3, 4, 5, 6, 7, 8}), 1000000), 160e-6, 1e-12);
}

TEST(SimulatedCanBus, AnAnswerComesAfterTheTimeOfBothFrames) {
  const auto bus = makeBus({0x10});
  SimulatedCanPort port(*bus);
  const Time start = port.now();
  port.send(makeRemote(0x10, 1), Duration{0});
  CanFrame frame;
  ASSERT_EQ(port.receive(frame, std::chrono::milliseconds(5)), StreamStatus::kOk);
  EXPECT_TRUE(frame == makeFrame(0x10, {0}));
  const double expected = calcFrameTime(makeRemote(0x10, 1), kBitrate) + calcFrameTime(frame, kBitrate);
  EXPECT_NEAR(seconds(port.now() - start), expected, 1e-8);
  EXPECT_EQ(port.receive(frame, std::chrono::milliseconds(5)), StreamStatus::kTimeout);
  EXPECT_NEAR(seconds(port.now() - start), expected + 5e-3, 1e-8);
}

TEST(SimulatedCanBus, TheLowestIdentifierGoesFirst) {
  const auto bus = makeBus({0x30, 0x10, 0x20});
  SimulatedCanPort port(*bus);
  for (const std::uint32_t id : {0x30u, 0x20u, 0x10u}) port.send(makeRemote(id, 1), Duration{0});
  std::vector<std::uint32_t> order;
  CanFrame frame;
  while (port.receive(frame, std::chrono::milliseconds(5)) == StreamStatus::kOk) order.push_back(frame.id);
  // All requests wait at once: 10 goes first, its answer is ready only when 20 has begun, and so on.
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0x10, 0x20, 0x30}));
}

TEST(SimulatedCanBus, StandardFramesWinOverExtendedOnesAndDataOverRemote) {
  const auto bus = makeBus({});
  SimulatedCanPort listener(*bus);
  std::vector<SimulatedCanBus::Member> members;
  struct Recorder : EchoNode {
    Recorder() : EchoNode(0x7FF, Duration{0}) {}
    void take(const CanFrame& f, Time, std::vector<CanFrame>&) override { seen.push_back(f); }
    std::vector<CanFrame> seen;
  };
  auto recorder = std::make_unique<Recorder>();
  std::vector<CanFrame>& seen = recorder->seen;
  members.push_back({std::move(recorder), {0}});
  SimulatedCanBus two(std::move(members), kBitrate);
  SimulatedCanPort port(two);
  CanFrame extended_remote = makeExtended(0x100 << 18, {});
  extended_remote.remote = true;
  const std::vector<CanFrame> sent{makeFrame(0x7F0, {}), extended_remote, makeExtended(0x100 << 18, {}),
                                   makeRemote(0x100, 0), makeFrame(0x100, {})};
  for (const CanFrame& f : sent) port.send(f, Duration{0});
  port.advanceTo(port.now() + std::chrono::milliseconds(5));
  ASSERT_EQ(seen.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_TRUE(seen[i] == sent[sent.size() - 1 - i]) << i;
}

TEST(SimulatedCanBus, DevicesSendByThemselvesWhileTimePasses) {
  const auto bus = makeBus({0x10, 0x20}, std::chrono::milliseconds(100));
  SimulatedCanPort port(*bus);
  port.advanceTo(port.now() + std::chrono::milliseconds(950));
  CanFrame frame;
  int count = 0;
  while (port.receive(frame, Duration{0}) == StreamStatus::kOk) ++count;
  EXPECT_EQ(count, 20);
}

TEST(SimulatedCanBus, EveryFaultIsCounted) {
  const auto bus = makeBus({0x10});
  SimulatedCanPort port(*bus);
  LineFaults faults;
  faults.corrupt = faults.drop = faults.delay = faults.duplicate = 0.1;
  bus->setLineFaults(faults);
  std::uint64_t received = 0;
  constexpr int kRequests = 2000;
  for (int n = 0; n < kRequests; ++n) {
    port.send(makeRemote(0x10, 1), Duration{0});
    CanFrame frame;
    while (port.receive(frame, std::chrono::milliseconds(1)) == StreamStatus::kOk) ++received;
  }
  port.advanceTo(port.now() + std::chrono::seconds(1));
  CanFrame frame;
  while (port.receive(frame, Duration{0}) == StreamStatus::kOk) ++received;
  const LineFaultCounts c = bus->lineFaultCounts();
  EXPECT_EQ(c.sent + c.corrupted + c.dropped + c.delayed + c.duplicated, static_cast<std::uint64_t>(kRequests));
  EXPECT_EQ(received, c.sent + c.delayed + 2 * c.duplicated);
  for (const std::uint64_t count : {c.corrupted, c.dropped, c.delayed, c.duplicated})
    EXPECT_NEAR(static_cast<double>(count), 0.1 * kRequests, 60.);
}

TEST(SimulatedCanBus, ADelayedFrameIsLateByItsDelay) {
  const auto bus = makeBus({0x10});
  SimulatedCanPort port(*bus);
  LineFaults faults;
  faults.delay = 1;
  bus->setLineFaults(faults);
  port.send(makeRemote(0x10, 1), Duration{0});
  CanFrame frame;
  EXPECT_EQ(port.receive(frame, std::chrono::milliseconds(20)), StreamStatus::kTimeout);
  EXPECT_EQ(port.receive(frame, std::chrono::milliseconds(1)), StreamStatus::kOk);
}

TEST(SimulatedCanBus, ThePluggedOutMasterIsAlone) {
  const auto bus = makeBus({0x10});
  SimulatedCanPort port(*bus);
  port.setPlugged(false);
  CanFrame frame;
  EXPECT_EQ(port.send(frame, Duration{0}), StreamStatus::kClosed);
  EXPECT_EQ(port.receive(frame, std::chrono::milliseconds(1)), StreamStatus::kClosed);
  port.setPlugged(true);
  EXPECT_EQ(port.receive(frame, std::chrono::milliseconds(1)), StreamStatus::kTimeout);
}

TEST(SimulatedCanBus, MechanicsGoToTheDeviceOfTheActuator) {
  std::vector<SimulatedCanBus::Member> members;
  members.push_back({std::make_unique<EchoNode>(0x10, Duration{0}), {1}});
  members.push_back({std::make_unique<EchoNode>(0x20, Duration{0}), {0}});
  SimulatedCanBus bus(std::move(members), kBitrate);
  bus.setLoadTorque(0, 1);
  bus.setLoadTorque(1, 2);
  bus.step(3);
  EXPECT_EQ(bus.shaftAngle(0), 3);
  EXPECT_EQ(bus.shaftAngle(1), 6);
  bus.powerCycle(1);
  EXPECT_EQ(bus.shaftAngle(1), 0);
}

TEST(SimulatedCanBus, RefusesActuatorsThatAreNotNumberedOnce) {
  for (const std::vector<int>& numbers : {std::vector<int>{0, 0}, std::vector<int>{1, 2}, std::vector<int>{-1, 0}}) {
    std::vector<SimulatedCanBus::Member> members;
    for (const int i : numbers) members.push_back({std::make_unique<EchoNode>(0x10, Duration{0}), {i}});
    EXPECT_THROW(SimulatedCanBus(std::move(members), kBitrate), ConfigError);
  }
}

TEST(SimulatedCanBus, ServesADriverBehindAnSlcanAdapter) {
  PseudoTerminal terminal;
  const auto bus = makeBus({0x10, 0x20});
  bus->start(terminal);
  const auto serial = std::make_shared<SerialPort>();
  ASSERT_TRUE(serial->open(terminal.path(), 1000000)) << serial->error();
  SlcanPort port;
  ASSERT_TRUE(port.open(serial, kBitrate, std::chrono::seconds(2))) << port.error();
  for (int n = 0; n < 50; ++n) {
    CanFrame frame;
    ASSERT_EQ(port.send(makeRemote(0x20, 1), std::chrono::seconds(5)), StreamStatus::kOk);
    ASSERT_EQ(port.receive(frame, std::chrono::seconds(5)), StreamStatus::kOk);
    EXPECT_TRUE(frame == makeFrame(0x20, {n}));
  }
  bus->stop();
}

}  // namespace
}  // namespace sinew
