#include "sinew/hardware/simulated_cia402_drive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace sinew {
namespace {

constexpr std::uint8_t kNode = 4;
constexpr double kTwoPi = 6.283185307179586;
constexpr std::uint32_t kPdoOff = 0x80000000;

/// Speaks to the drive in plain bytes.
class Drive : public testing::Test {
 protected:
  void make(const SimulatedCia402Drive::Parameters& parameters = {}) {
    drive = std::make_unique<SimulatedCia402Drive>(kNode, parameters);
    out.clear();
  }
  void SetUp() override { make(); }

  void send(std::uint32_t id, const std::vector<std::uint8_t>& data) {
    CanFrame frame;
    frame.id = id;
    frame.size = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), frame.data.begin());
    drive->take(frame, now, out);
  }
  /// Abort code, 0 when taken.
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::size_t size, std::int64_t value) {
    std::vector<std::uint8_t> data{static_cast<std::uint8_t>(0x23 | (4 - size) << 2), static_cast<std::uint8_t>(index),
                                   static_cast<std::uint8_t>(index >> 8), sub};
    for (std::size_t i = 0; i < 4; ++i)
      data.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
    const std::size_t before = out.size();
    send(0x600 + kNode, data);
    if (out.size() == before) return 1;
    const auto& d = out.back().data;
    return d[0] == 0x60 ? 0 : static_cast<std::uint32_t>(d[4] | d[5] << 8 | d[6] << 16) | std::uint32_t{d[7]} << 24;
  }
  void control(std::uint16_t word) { ASSERT_EQ(write(0x6040, 0, 2, word), 0u); }
  unsigned state() const { return drive->statusword() & 0x6Fu; }
  void nmt(std::uint8_t command) { send(0x000, {command, kNode}); }
  void enable(int mode = 8) {
    ASSERT_EQ(write(0x6060, 0, 1, mode), 0u);
    ASSERT_EQ(write(0x607A, 0, 4, drive->object(0x6064)), 0u);
    for (const int word : {0x06, 0x07, 0x0F}) control(static_cast<std::uint16_t>(word));
    ASSERT_EQ(state(), 0x27u);
  }
  void pass(double dt, double tick = 1e-3) {
    for (double t = 0; t < dt - 1e-9; t += tick) {
      now += duration(tick);
      drive->step(tick);
      drive->update(now, out);
    }
  }
  int count(std::uint32_t id, std::function<bool(const CanFrame&)> what = {}) const {
    int n = 0;
    for (const CanFrame& f : out) n += f.id == id && (!what || what(f)) ? 1 : 0;
    return n;
  }
  int emergencies(std::uint16_t code) const {
    return count(0x80 + kNode, [&](const CanFrame& f) { return (f.data[0] | f.data[1] << 8) == code; });
  }

  std::unique_ptr<SimulatedCia402Drive> drive;
  std::vector<CanFrame> out;
  Time now = Time{} + duration(50);
};

// --- State machine: every state against every command of CiA 402-2, "Device control commands" ---

constexpr unsigned kDisabled = 0x40, kReady = 0x21, kOn = 0x23, kEnabled = 0x27, kQuickStop = 0x07, kFault = 0x08;

TEST_F(Drive, EveryTransition) {
  struct Case {
    unsigned from;
    std::uint16_t word;
    unsigned to;
  };
  constexpr Case kCases[] = {{kDisabled, 0x06, kReady},
                             {kDisabled, 0x07, kDisabled},
                             {kDisabled, 0x0F, kDisabled},
                             {kDisabled, 0x00, kDisabled},
                             {kDisabled, 0x02, kDisabled},
                             {kDisabled, 0x80, kDisabled},
                             {kReady, 0x06, kReady},
                             {kReady, 0x07, kOn},
                             {kReady, 0x0F, kEnabled},
                             {kReady, 0x00, kDisabled},
                             {kReady, 0x02, kDisabled},
                             {kOn, 0x06, kReady},
                             {kOn, 0x07, kOn},
                             {kOn, 0x0F, kEnabled},
                             {kOn, 0x00, kDisabled},
                             {kOn, 0x02, kDisabled},
                             {kEnabled, 0x06, kReady},
                             {kEnabled, 0x07, kOn},
                             {kEnabled, 0x0F, kEnabled},
                             {kEnabled, 0x00, kDisabled},
                             {kEnabled, 0x02, kQuickStop},
                             {kQuickStop, 0x00, kDisabled},
                             {kQuickStop, 0x02, kQuickStop},
                             {kQuickStop, 0x0F, kEnabled},
                             {kQuickStop, 0x06, kQuickStop},
                             {kFault, 0x06, kFault},
                             {kFault, 0x0F, kFault},
                             {kFault, 0x00, kFault},
                             {kFault, 0x80, kDisabled}};
  for (const Case& c : kCases) {
    make();
    ASSERT_EQ(write(0x605A, 0, 2, 6), 0u);
    if (c.from == kFault) {
      drive->setTemperature(200);
      pass(0.01);
      drive->setTemperature(30);
    } else if (c.from != kDisabled) {
      control(0x06);
      if (c.from != kReady) control(0x07);
      if (c.from == kEnabled || c.from == kQuickStop) control(0x0F);
      if (c.from == kQuickStop) control(0x02);
    }
    ASSERT_EQ(state() & ~(c.from == kFault ? 0x20u : 0u), c.from);
    control(c.word);
    EXPECT_EQ(state() & ~(c.to == kFault ? 0x20u : 0u), c.to) << std::hex << c.from << " " << c.word;
  }
}

TEST_F(Drive, FaultIsResetByTheEdgeAndOnlyOnceItsCauseIsGone) {
  control(0x80);
  drive->setTemperature(200);
  EXPECT_EQ(state() & 0x4F, kFault);
  control(0x80);  // no edge
  EXPECT_EQ(state() & 0x4F, kFault);
  control(0x00);
  control(0x80);
  EXPECT_EQ(state() & 0x4F, kFault);  // still hot
  drive->setTemperature(30);
  control(0x00);
  control(0x80);
  EXPECT_EQ(state(), kDisabled);
}

TEST_F(Drive, QuickStopOptions) {
  ASSERT_EQ(write(0x605A, 0, 2, 2), 0u);
  enable();
  control(0x02);
  EXPECT_EQ(state(), kQuickStop);
  pass(0.01);
  EXPECT_EQ(state(), kDisabled);
  ASSERT_EQ(write(0x605A, 0, 2, 0), 0u);
  enable();
  control(0x02);
  EXPECT_EQ(state(), kDisabled);
}

TEST_F(Drive, QuickStopRampsDownAndHolds) {
  ASSERT_EQ(write(0x605A, 0, 2, 6), 0u);
  ASSERT_EQ(write(0x6085, 0, 4, 1000), 0u);  // rpm/s of the motor: 10.47 rad/s2 of the spool
  ASSERT_EQ(write(0x60C2, 1, 1, 100), 0u);
  ASSERT_EQ(write(0x6065, 0, 4, 0xFFFFFFFF), 0u);
  enable();
  drive->setLoadTorque(0, -0.2);
  ASSERT_EQ(write(0x607A, 0, 4, 20480), 0u);  // half a turn in 0.1 s: 31.4 rad/s, more than the motor's 30
  pass(0.05);
  const double before = drive->shaftAngle(0);
  EXPECT_NEAR(before, 30 * (0.05 - 0.005), 0.05);  // behind by its response time
  control(0x02);
  pass(5);
  EXPECT_EQ(state(), kQuickStop);
  const double stopped = drive->shaftAngle(0);
  EXPECT_NEAR(stopped - before, 30 * 30 / (2 * 10.47), 1);
  pass(1);
  EXPECT_NEAR(drive->shaftAngle(0), stopped, 1e-6);
}

// --- Network ---

TEST_F(Drive, BootsUpOnceAndBeatsAsOftenAsTold) {
  pass(0.1);
  EXPECT_EQ(count(0x704), 1);
  EXPECT_EQ(out.front().data[0], 0);
  ASSERT_EQ(write(0x1017, 0, 2, 20), 0u);
  out.clear();
  pass(1);
  EXPECT_NEAR(count(0x704), 50, 2);
  EXPECT_EQ(count(0x704, [](const CanFrame& f) { return f.data[0] == 0x7F; }), count(0x704));
  nmt(0x01);
  out.clear();
  pass(0.1);
  EXPECT_EQ(count(0x704, [](const CanFrame& f) { return f.data[0] == 0x05; }), count(0x704));
  nmt(0x02);
  EXPECT_EQ(write(0x1017, 0, 2, 0), 1u) << "stopped nodes have no SDO";
  nmt(0x82);
  out.clear();
  pass(0.1);
  EXPECT_EQ(count(0x704), 1) << "the heartbeat is off again";
}

TEST_F(Drive, MissesTheDriverOnlyOnceItHasHeardIt) {
  ASSERT_EQ(write(0x1016, 1, 4, 127 << 16 | 50), 0u);
  ASSERT_EQ(write(0x6007, 0, 2, 3), 0u);
  ASSERT_EQ(write(0x605A, 0, 2, 6), 0u);
  ASSERT_EQ(write(0x1029, 1, 1, 1), 0u);
  nmt(0x01);
  enable();
  pass(1);
  EXPECT_EQ(state(), kEnabled);
  for (int i = 0; i < 10; ++i) {
    send(0x77F, {0x05});
    pass(0.04);
  }
  EXPECT_EQ(state(), kEnabled);
  pass(0.012);
  EXPECT_EQ(state(), kQuickStop);
  EXPECT_EQ(emergencies(0x8130), 1);
}

TEST_F(Drive, WhatHappensWithoutTheDriverIsItsOption) {
  const unsigned expected[] = {kEnabled, kFault, kDisabled, kQuickStop};
  for (int option = 0; option < 4; ++option) {
    make();
    ASSERT_EQ(write(0x1016, 1, 4, 127 << 16 | 50), 0u);
    ASSERT_EQ(write(0x6007, 0, 2, option), 0u);
    ASSERT_EQ(write(0x605A, 0, 2, 6), 0u);
    enable();
    send(0x77F, {0x05});
    pass(0.1);
    EXPECT_EQ(state() & (option == 1 ? 0x4Fu : 0x6Fu), expected[option]) << option;
  }
}

// --- PDOs: CiA 301, "PDO mapping procedure" ---

TEST_F(Drive, MapsOnlyWhatFitsAndOnlyWhileThePdoIsOff) {
  EXPECT_EQ(write(0x1A00, 0, 1, 0), 0x08000022u) << "the PDO is on";
  ASSERT_EQ(write(0x1800, 1, 4, kPdoOff | 0x184), 0u);
  EXPECT_EQ(write(0x1A00, 1, 4, 0x60640020), 0x06010000u) << "not emptied";
  ASSERT_EQ(write(0x1A00, 0, 1, 0), 0u);
  EXPECT_EQ(write(0x1A00, 1, 4, 0x60400010), 0x06040041u) << "the controlword is not sent";
  EXPECT_EQ(write(0x1A00, 1, 4, 0x60640010), 0x06040041u) << "wrong length";
  EXPECT_EQ(write(0x1A00, 1, 4, 0x99990010), 0x06040041u) << "no such object";
  ASSERT_EQ(write(0x1A00, 1, 4, 0x60640020), 0u);
  ASSERT_EQ(write(0x1A00, 2, 4, 0x60620020), 0u);
  ASSERT_EQ(write(0x1A00, 3, 4, 0x60410010), 0u);
  EXPECT_EQ(write(0x1A00, 0, 1, 3), 0x06040042u) << "ten bytes";
  EXPECT_EQ(write(0x1A00, 0, 1, 4), 0x06040041u) << "an empty entry";
  ASSERT_EQ(write(0x1A00, 0, 1, 2), 0u);
  EXPECT_EQ(write(0x1800, 2, 1, 245), 0x06090030u) << "reserved";
  ASSERT_EQ(write(0x1800, 2, 1, 1), 0u);
  EXPECT_EQ(write(0x1800, 1, 4, 0x004), 0x06090030u) << "an identifier of the NMT";
  ASSERT_EQ(write(0x1800, 1, 4, 0x40000184), 0u);
  EXPECT_EQ(write(0x1800, 1, 4, 0x40000185), 0x06090030u) << "another identifier while on";
  EXPECT_EQ(write(0x1800, 2, 1, 5), 0x08000022u);
  nmt(0x01);
  ASSERT_EQ(write(0x1800, 1, 4, kPdoOff | 0x184), 0u);
  EXPECT_EQ(write(0x1A00, 0, 1, 0), 0x08000022u) << "operational";
}

TEST_F(Drive, SynchronousPdosWaitForTheSync) {
  ASSERT_EQ(write(0x1400, 1, 4, kPdoOff | 0x204), 0u);
  ASSERT_EQ(write(0x1400, 2, 1, 1), 0u);
  ASSERT_EQ(write(0x1400, 1, 4, 0x204), 0u);
  ASSERT_EQ(write(0x1800, 1, 4, kPdoOff | 0x184), 0u);
  ASSERT_EQ(write(0x1800, 2, 1, 2), 0u);
  ASSERT_EQ(write(0x1800, 1, 4, 0x40000184), 0u);
  send(0x204, {0x06, 0x00});
  send(0x080, {});
  EXPECT_EQ(state(), kDisabled) << "not operational";
  nmt(0x01);
  send(0x204, {0x06, 0x00});
  EXPECT_EQ(state(), kDisabled);
  out.clear();
  send(0x080, {});
  EXPECT_EQ(state(), kReady);
  EXPECT_EQ(count(0x184), 0) << "every second SYNC";
  send(0x080, {});
  ASSERT_EQ(count(0x184), 1);
  EXPECT_EQ(out.back().size, 2);
  EXPECT_EQ(out.back().data[0] & 0x6F, static_cast<int>(kReady));
  send(0x204, {0x07});
  send(0x080, {});
  pass(0.002);
  EXPECT_EQ(state(), kReady) << "too short";
  EXPECT_EQ(emergencies(0x8210), 1);
}

// The factory's PDOs: at once, and whenever they change.
TEST_F(Drive, EventDrivenPdos) {
  nmt(0x01);
  out.clear();
  pass(0.1);
  EXPECT_EQ(count(0x184), 1);
  send(0x204, {0x06, 0x00});
  EXPECT_EQ(state(), kReady);
  pass(0.1);
  EXPECT_EQ(count(0x184), 2);
}

// --- Motion ---

TEST_F(Drive, InterpolatesBetweenTargets) {
  ASSERT_EQ(write(0x60C2, 1, 1, 10), 0u);
  enable();
  ASSERT_EQ(write(0x607A, 0, 4, 1000), 0u);
  std::vector<double> demand;
  for (int ms = 0; ms < 12; ++ms) {
    pass(1e-3);
    demand.push_back(static_cast<double>([&] {
      write(0x60C2, 1, 1, 10);  // any SDO brings the readings up to date
      return drive->object(0x6062);
    }()));
  }
  for (std::size_t ms = 0; ms < demand.size(); ++ms)
    EXPECT_NEAR(demand[ms], std::min(1000., 100. * (static_cast<double>(ms) + 1)), 1) << ms;
}

TEST_F(Drive, AStaleTargetMovesTheShaftWhenItIsEnabled) {
  ASSERT_EQ(write(0x6065, 0, 4, 0xFFFFFFFF), 0u);
  drive->setShaftAngle(1);
  ASSERT_EQ(write(0x6060, 0, 1, 8), 0u);
  ASSERT_EQ(write(0x607A, 0, 4, 0), 0u);
  for (const int word : {0x06, 0x07, 0x0F}) control(static_cast<std::uint16_t>(word));
  pass(0.5);
  EXPECT_NEAR(drive->shaftAngle(0), 0, 1e-3);
}

TEST_F(Drive, EachLimitBoundsItsTorque) {
  struct Case {
    std::uint16_t index;
    std::uint8_t subindex, size;
    std::int64_t value;
  };
  // 0.1 N m and 2 A rated, gear 10: each is half a rated torque, 0.5 N m at the spool.
  for (const Case& c : {Case{0x6072, 0, 2, 500}, Case{0x6073, 0, 2, 500}, Case{0x3001, 2, 4, 1000}}) {
    make();
    ASSERT_EQ(write(0x6065, 0, 4, 0xFFFFFFFF), 0u);
    enable();
    ASSERT_EQ(write(c.index, c.subindex, c.size, c.value), 0u);
    drive->setLoadTorque(0, -0.4);
    pass(0.5);
    EXPECT_NEAR(drive->shaftAngle(0), 0, 0.01);
    EXPECT_NEAR(drive->motorTorque(), 0.4, 1e-3);
    EXPECT_EQ(drive->statusword() & 0x800, 0);
    drive->setLoadTorque(0, -0.6);
    pass(0.1);
    EXPECT_NEAR(drive->motorTorque(), 0.5, 1e-9);
    EXPECT_NE(drive->statusword() & 0x800, 0);
    EXPECT_LT(drive->shaftAngle(0), -0.5);
  }
}

TEST_F(Drive, AlarmsWhenItCannotFollow) {
  ASSERT_EQ(write(0x6065, 0, 4, 400), 0u);
  ASSERT_EQ(write(0x6066, 0, 2, 50), 0u);
  enable();
  ASSERT_EQ(write(0x6072, 0, 2, 100), 0u);
  drive->setLoadTorque(0, -0.5);
  pass(0.04);
  EXPECT_NE(drive->statusword() & 0x2000, 0);
  EXPECT_EQ(state(), kEnabled);
  pass(0.5);
  EXPECT_EQ(state() & 0x4F, kFault);
  EXPECT_EQ(emergencies(0x8611), 1);
  EXPECT_EQ(drive->object(0x603F), 0x8611);
}

TEST_F(Drive, HomesToASwitch) {
  SimulatedCia402Drive::Parameters parameters;
  parameters.lower_switch = -1;
  make(parameters);
  ASSERT_EQ(write(0x6098, 0, 1, 17), 0u);
  ASSERT_EQ(write(0x6099, 1, 4, 100), 0u);
  ASSERT_EQ(write(0x6099, 2, 4, 10), 0u);
  ASSERT_EQ(write(0x609A, 0, 4, 1000), 0u);
  ASSERT_EQ(write(0x607C, 0, 4, 500), 0u);
  enable(6);
  pass(0.5);
  EXPECT_EQ(drive->shaftAngle(0), 0) << "it waits for its start bit";
  control(0x1F);
  pass(0.1);
  EXPECT_EQ(drive->statusword() & 0x3400, 0);
  pass(5);
  EXPECT_EQ(drive->statusword() & 0x3400, 0x1400);
  EXPECT_NEAR(drive->shaftAngle(0), -1, 2e-3);
  control(0x0F);
  EXPECT_EQ(drive->object(0x6064), 500) << "home offset";
}

TEST_F(Drive, UnknownMethodsAndModesAreRefused) {
  EXPECT_EQ(write(0x6098, 0, 1, 5), 0x06090030u);
  EXPECT_EQ(write(0x6060, 0, 1, 3), 0x06090030u);
}

// --- Faults ---

TEST_F(Drive, OverheatsAndLosesItsSupply) {
  enable();
  drive->setTemperature(120);
  pass(0.01);
  EXPECT_EQ(state() & 0x4F, kFault);
  EXPECT_EQ(emergencies(0x4210), 1);
  make();
  enable();
  drive->setSupplyVoltage(12);
  pass(0.01);
  EXPECT_EQ(emergencies(0x3220), 1);
  EXPECT_FALSE(drive->energised(0));
  make();
  enable();
  pass(0.01);
  out.clear();
  drive->setSupplyVoltage(5);
  pass(0.1);
  EXPECT_EQ(write(0x6072, 0, 2, 1), 1u) << "off";
  drive->setSupplyVoltage(24);
  pass(0.01);
  EXPECT_EQ(count(0x704, [](const CanFrame& f) { return f.data[0] == 0; }), 1) << "it starts again";
}

TEST_F(Drive, PositionAfterPowerLossIsAMatterOfItsEncoder) {
  for (const bool absolute : {false, true}) {
    SimulatedCia402Drive::Parameters parameters;
    parameters.absolute_encoder = absolute;
    make(parameters);
    drive->setShaftAngle(kTwoPi / 4);
    drive->powerCycle();
    EXPECT_EQ(drive->object(0x6064), absolute ? 10240 : 0);
    EXPECT_EQ(drive->object(0x1016, 1), 0);
    EXPECT_EQ(drive->object(0x6060), 1);
  }
}

TEST_F(Drive, AFrozenDriveNeitherAnswersNorMoves) {
  enable();
  drive->setFrozen(true);
  drive->setLoadTorque(0, -100);
  const double before = drive->shaftAngle(0);
  pass(0.1);
  EXPECT_EQ(drive->shaftAngle(0), before);
  EXPECT_EQ(write(0x6072, 0, 2, 1), 1u);
}

TEST_F(Drive, ALimpShaftIsHeldByItsGearOnly) {
  drive->setLoadTorque(0, 0.019);
  pass(1);
  EXPECT_EQ(drive->shaftAngle(0), 0);
  drive->setLoadTorque(0, 0.03);
  pass(1);
  EXPECT_NEAR(drive->shaftAngle(0), 1, 1e-6);  // (0.03 - 0.02) N m against 0.01 N m s/rad
}

}  // namespace
}  // namespace sinew
