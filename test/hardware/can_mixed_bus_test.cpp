// Drives of both protocols on one bus: each hears only its own frames, and the cycle takes no memory.

#include <gtest/gtest.h>

#include <memory>

#include "sinew/hardware/can_device_bus.h"
#include "sinew/hardware/canopen_drive.h"
#include "sinew/hardware/odrive_axis.h"
#include "sinew/hardware/simulated_can_bus.h"
#include "sinew/hardware/simulated_can_port.h"
#include "sinew/hardware/simulated_cia402_drive.h"
#include "sinew/hardware/simulated_odrive.h"
#include "solver/allocation_count.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.01, kRadius = 0.01;
// ODrive documentation, "CAN Protocol", interoperability with CANopen: nodes 10 and 18 (hexadecimal) are out of the way
// of CANopen nodes from 32 on.
constexpr int kOdrives[] = {0x10, 0x18};
constexpr int kDrives[] = {33, 34};

// A simulated port; what it allocates itself does not count.
class WatchedPort : public CanPort {
 public:
  explicit WatchedPort(SimulatedCanBus& bus) : port_(bus) {}
  StreamStatus send(const CanFrame& frame, Duration timeout) override {
    const long before = allocationCount();
    const StreamStatus status = port_.send(frame, timeout);
    own_allocations_ += allocationCount() - before;
    if (frame.id == 0x080 && !frame.extended) ++syncs;
    return status;
  }
  StreamStatus receive(CanFrame& frame, Duration timeout) override {
    const long before = allocationCount();
    const StreamStatus status = port_.receive(frame, timeout);
    own_allocations_ += allocationCount() - before;
    return status;
  }
  Time now() const override { return port_.now(); }
  void advance(double time) { port_.advanceTo(port_.now() + duration(time)); }
  long ownAllocations() const { return own_allocations_; }

  int syncs = 0;

 private:
  SimulatedCanPort port_;
  long own_allocations_ = 0;
};

struct Bench {
  Bench() {
    const DeviceTiming timing{kPeriod, 0.1, 0.004, 10};
    WinchDescription cable;
    cable.spool_radius = kRadius;
    cable.torque_constant = 0.5;
    cable.tension_max = 20;
    std::vector<SimulatedCanBus::Member> simulated;
    std::vector<CanDeviceBus::Member> members;
    for (int i = 0; i < 2; ++i) {
      OdriveSettings odrive;
      odrive.node = kOdrives[i];
      CanopenSettings canopen;
      canopen.node = static_cast<std::uint8_t>(kDrives[i]);
      canopen.driver_node = 127;
      canopen.counts_per_turn = 4096;
      canopen.gear = 10;
      canopen.rated_unit = 1e-3;
      canopen.heartbeat = 0.05;
      const ActuatorBounds bounds{"cable", -0.1, 0.1, 0.2};
      simulated.push_back({std::make_unique<SimulatedOdrive>(odrive.node, SimulatedOdrive::Parameters()), {2 * i}});
      simulated.push_back(
          {std::make_unique<SimulatedCia402Drive>(canopen.node, SimulatedCia402Drive::Parameters()), {2 * i + 1}});
      members.push_back({std::make_unique<OdriveAxis>(odrive, cable, bounds, timing), {2 * i}});
      members.push_back({std::make_unique<CanopenDrive>(canopen, cable, bounds, timing), {2 * i + 1}});
    }
    line = std::make_unique<SimulatedCanBus>(std::move(simulated), 1000000);
    port = std::make_shared<WatchedPort>(*line);
    bus = std::make_unique<CanDeviceBus>([this](std::string&) { return port; }, std::move(members), timing);
    std::string why;
    bus->open(why);
  }
  void pass() {
    line->step(kPeriod);
    port->advance(kPeriod);
  }
  bool setUp() {
    bus->startSetUp(false);
    SetUpProgress progress = SetUpProgress::kBusy;
    for (int n = 0; n < 2000 && progress == SetUpProgress::kBusy; ++n) {
      progress = bus->updateSetUp(port->now());
      pass();
    }
    return progress == SetUpProgress::kDone;
  }
  bool run(const std::vector<double>& set_points, int cycles) {
    bool ok = true;
    for (int n = 0; n < cycles; ++n) {
      ok = bus->writeSetPoints(set_points.data(), port->now()) && bus->read(port->now()) && ok;
      pass();
    }
    return ok;
  }
  std::unique_ptr<SimulatedCanBus> line;
  std::shared_ptr<WatchedPort> port;
  std::unique_ptr<CanDeviceBus> bus;
};

TEST(CanMixedBus, IsSetUpWithoutMotionAndFollows) {
  Bench b;
  ASSERT_TRUE(b.setUp()) << b.bus->problem();
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(b.line->shaftAngle(i), 0, 1e-6) << i;
    EXPECT_TRUE(b.line->energised(i)) << i;
  }
  const std::vector<double> set_points{0.01, 0.02, -0.01, -0.02};
  const int syncs = b.port->syncs;
  ASSERT_TRUE(b.run(set_points, 100));
  EXPECT_EQ(b.port->syncs, syncs + 100);
  for (std::size_t i = 0; i < 4; ++i) {
    const ActuatorReading& r = b.bus->readings()[i];
    EXPECT_TRUE(r.valid) << i;
    EXPECT_EQ(r.fault, 0u) << i << ": " << b.bus->faultDetail(static_cast<int>(i));
    EXPECT_NEAR(r.measured, set_points[i], 1e-5) << i;
    EXPECT_NEAR(kRadius * b.line->shaftAngle(static_cast<int>(i)), set_points[i], 1e-5) << i;
  }
  EXPECT_EQ(b.bus->strangers(), 0u);
  EXPECT_EQ(b.bus->counters().missing, 0u);
}

TEST(CanMixedBus, EveryDriveStopsByItselfWhenTheMasterFallsSilent) {
  Bench b;
  ASSERT_TRUE(b.setUp()) << b.bus->problem();
  b.run({0.01, 0.01, 0.01, 0.01}, 100);
  for (int n = 0; n < 30; ++n) b.pass();
  std::vector<double> angles;
  for (int i = 0; i < 4; ++i) angles.push_back(b.line->shaftAngle(i));
  for (int n = 0; n < 30; ++n) b.pass();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(b.line->shaftAngle(i), angles[static_cast<std::size_t>(i)]);
  EXPECT_FALSE(b.line->energised(0) || b.line->energised(2));
  b.run({0.01, 0.01, 0.01, 0.01}, 12);
  for (const ActuatorReading& r : b.bus->readings()) EXPECT_NE(r.fault, 0u);
}

TEST(CanMixedBus, AFrozenDriveDoesNotDisturbTheOthers) {
  for (int frozen = 0; frozen < 2; ++frozen) {
    Bench b;
    ASSERT_TRUE(b.setUp()) << b.bus->problem();
    b.run({0.01, 0.01, 0.01, 0.01}, 50);
    b.line->setFrozen(frozen, true);
    ASSERT_TRUE(b.run({0.01, 0.01, 0.01, 0.01}, 15));
    for (int i = 0; i < 4; ++i) {
      const ActuatorReading& r = b.bus->readings()[static_cast<std::size_t>(i)];
      EXPECT_EQ((r.fault & kFaultSilent) != 0, i == frozen) << i;
      EXPECT_EQ(r.valid, i != frozen) << i;
    }
  }
}

TEST(CanMixedBus, TheCycleTakesNoMemory) {
  if (!countsAllocations()) GTEST_SKIP() << "nothing counts in this build";
  Bench b;
  ASSERT_TRUE(b.setUp()) << b.bus->problem();
  const std::vector<double> set_points{0.01, 0.02, -0.01, -0.02};
  b.run(set_points, 20);
  LineFaults faults;
  faults.corrupt = faults.drop = faults.delay = faults.duplicate = 0.05;
  b.line->setLineFaults(faults);
  const std::vector<bool> all(4, true);
  long allocations = 0;
  for (int n = 0; n < 300; ++n) {
    if (n == 200) b.line->setTemperature(0, 200);
    if (n == 220) b.line->setFrozen(1, true);
    const long before = allocationCount() - b.port->ownAllocations();
    b.bus->writeSetPoints(set_points.data(), b.port->now());
    b.bus->read(b.port->now());
    if (n > 250) b.bus->relax(all, (300 - n) / 50.);
    if (n == 299) b.bus->switchOff(all);
    allocations += allocationCount() - b.port->ownAllocations() - before;
    b.pass();
  }
  EXPECT_EQ(allocations, 0);
}

}  // namespace
}  // namespace sinew
