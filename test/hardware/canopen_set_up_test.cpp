#include "sinew/hardware/canopen_set_up.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "hardware/canopen_rig.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

using Rig = CanopenRig;

void expectFailure(Rig& rig, const std::string& words) {
  EXPECT_EQ(rig.setUp(), SetUpProgress::kFailed);
  EXPECT_NE(rig.drive.problem().find(words), std::string::npos) << rig.drive.problem();
  EXPECT_FALSE(rig.node.energised(0));
}

// CiA 301, "PDO communication parameter" and "PDO mapping parameter"; CiA 402, "Interpolation time period".
TEST(CanopenSetUp, WhatTheDriveHasInTheEnd) {
  Rig rig;
  ASSERT_EQ(rig.setUp(), SetUpProgress::kDone) << rig.drive.problem();
  const SimulatedCia402Drive& d = rig.node;
  EXPECT_EQ(d.object(0x1400, 1), 0x205);
  EXPECT_EQ(d.object(0x1400, 2), 1);
  EXPECT_EQ(d.object(0x1600, 0), 2);
  EXPECT_EQ(d.object(0x1600, 1), 0x60400010);
  EXPECT_EQ(d.object(0x1600, 2), 0x607A0020);
  EXPECT_EQ(d.object(0x1800, 1), 0x40000185);
  EXPECT_EQ(d.object(0x1800, 2), 1);
  EXPECT_EQ(d.object(0x1A00, 0), 2);
  EXPECT_EQ(d.object(0x1A00, 1), 0x60410010);
  EXPECT_EQ(d.object(0x1A00, 2), 0x60640020);
  EXPECT_EQ(d.object(0x1801, 1), 0x40000285);
  EXPECT_EQ(d.object(0x1A01, 0), 1);
  EXPECT_EQ(d.object(0x1A01, 1), 0x60770010);
  EXPECT_EQ(d.object(0x1802, 1) & 0x80000000, 0x80000000);
  EXPECT_EQ(d.object(0x1016, 1), 127 << 16 | 100);
  EXPECT_EQ(d.object(0x1017), 50);
  EXPECT_EQ(d.object(0x1029, 1), 1);
  EXPECT_EQ(d.object(0x6007), 3);
  EXPECT_EQ(d.object(0x605A), 6);
  EXPECT_EQ(d.object(0x6060), 8);
  EXPECT_EQ(d.object(0x6065), 0xFFFFFFFF);
  EXPECT_EQ(d.object(0x6072), 200);
  EXPECT_EQ(d.object(0x60C2, 1), 10);
  EXPECT_EQ(d.object(0x60C2, 2), -3);
  // 1.2 times 0.2 m/s by 0.01 m: 24 rad/s of the spool, 240 of the motor, 2291.8 rpm.
  EXPECT_EQ(d.object(0x607F), 2292);
  EXPECT_EQ(d.object(0x6080), 2292);
}

TEST(CanopenSetUp, WritesTheUsersObjects) {
  CanopenSettings settings = Rig::makeSettings();
  settings.objects.push_back({0x6085, 0, 4, 4321});
  Rig rig(settings);
  ASSERT_EQ(rig.setUp(), SetUpProgress::kDone) << rig.drive.problem();
  EXPECT_EQ(rig.node.object(0x6085), 4321);
}

TEST(CanopenSetUp, ARefusedObjectIsNamedWithTheReason) {
  CanopenSettings settings = Rig::makeSettings();
  settings.objects.push_back({0x6085, 0, 2, 4321});
  Rig rig(settings);
  expectFailure(rig, "refuses object 0x6085:00 = 0x10E1: too short for the object's type (0x6070013)");
  settings.objects[0] = {0x2345, 6, 2, 0};
  Rig other(settings);
  expectFailure(other, "refuses object 0x2345:06 = 0x0: no such object (0x6020000)");
}

TEST(CanopenSetUp, OnlyDrivesOfTheProfileAndMaker) {
  SimulatedCia402Drive::Parameters parameters;
  parameters.device_type = 0x00020191;  // an input and output device, 401
  Rig wrong_profile(Rig::makeSettings(), Rig::makeCable(), parameters);
  expectFailure(wrong_profile, "0x191 in object 0x1000:00, expected 0x192");
  CanopenSettings settings = Rig::makeSettings();
  settings.vendor = 0xFB;
  settings.product = 0x1234;
  Rig wrong_product(settings);
  expectFailure(wrong_product, "0x1018:02, expected 0x1234");
  settings.product = 0x63500000;
  Rig right(settings);
  EXPECT_EQ(right.setUp(), SetUpProgress::kDone) << right.drive.problem();
}

TEST(CanopenSetUp, TheTensionHasToBeBounded) {
  SimulatedCia402Drive::Parameters parameters;
  parameters.rated_torque = 0;
  Rig unconfigured(Rig::makeSettings(), Rig::makeCable(), parameters);
  expectFailure(unconfigured, "0x6076:00: its motor is not configured");
  WinchDescription cable = Rig::makeCable();
  cable.tension_max = 0.01;
  Rig too_fine(Rig::makeSettings(), cable);
  expectFailure(too_fine, "cannot bound its tension");
  CanopenSettings settings = Rig::makeSettings();
  settings.rated_unit = 1e-6;  // a rating in mN m taken for micro N m
  Rig too_much(settings);
  expectFailure(too_much, "cannot bound its tension");
}

TEST(CanopenSetUp, PeriodsThatADriveCanBeTold) {
  DeviceTiming timing = Rig::makeTiming();
  const auto make = [&] { CanopenSetUp(Rig::makeSettings(), Rig::makeCable(), Rig::makeBounds(), timing); };
  for (const double period : {0.001, 0.002, 0.0025, 0.004, 0.01, 0.02, 0.1, 0.0001, 1 / 80., 1 / 125.}) {
    timing.period = period;
    EXPECT_NO_THROW(make()) << period;
  }
  for (const double period : {1 / 30., 1 / 300., 1., 1e-7}) {
    timing.period = period;
    EXPECT_THROW(make(), ConfigError) << period;
  }
  timing.period = 0.01;
  timing.watchdog = 70;
  EXPECT_THROW(make(), ConfigError);
}

TEST(CanopenSetUp, TakesPartsOfAMillisecond) {
  DeviceTiming timing = Rig::makeTiming();
  timing.period = 0.0025;
  CanopenBench bench(0.0025);
  SimulatedCia402Drive node(5, {});
  CanopenDrive drive(Rig::makeSettings(), Rig::makeCable(), Rig::makeBounds(), timing);
  bench.add(node);
  bench.add(drive);
  ASSERT_EQ(bench.setUp(drive), SetUpProgress::kDone) << drive.problem();
  EXPECT_EQ(node.object(0x60C2, 1), 25);
  EXPECT_EQ(node.object(0x60C2, 2), -4);
}

// A drive that cannot be stopped by the driver's silence is not used.
TEST(CanopenSetUp, SupervisionIsNotOptional) {
  struct Deaf : CanSender {
    explicit Deaf(Rig& r) : rig(&r) {}
    bool send(const CanFrame& frame) override {
      const bool hit = frame.id == 0x605 && frame.data[0] == 0x2B && frame.data[1] == 0x07 && frame.data[2] == 0x60;
      if (!hit) return rig->bench.send(frame);
      CanFrame reply;
      reply.id = 0x585;
      reply.size = 8;
      reply.data = {0x80, 0x07, 0x60, 0x00, 0x00, 0x00, 0x02, 0x06};
      rig->drive.take(reply, rig->bench.now());
      answer = reply;
      return true;
    }
    Rig* rig;
    CanFrame answer;
  };
  Rig rig;
  Deaf deaf(rig);
  rig.drive.startSetUp(false);
  SetUpProgress progress = SetUpProgress::kBusy;
  for (int i = 0; i < 500 && progress == SetUpProgress::kBusy; ++i) {
    rig.bench.deliver();
    if (deaf.answer.size != 0) rig.drive.take(deaf.answer, rig.bench.now());
    progress = rig.drive.updateSetUp(rig.bench.now(), deaf);
    rig.bench.pass(0.01);
  }
  EXPECT_EQ(progress, SetUpProgress::kFailed);
  EXPECT_NE(rig.drive.problem().find("refuses object 0x6007:00"), std::string::npos) << rig.drive.problem();
}

}  // namespace
}  // namespace sinew
