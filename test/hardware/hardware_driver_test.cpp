#include "sinew/hardware/hardware_driver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "hardware/check_line.h"
#include "hardware/driver_bench.h"

namespace sinew {
namespace {

constexpr int kServos = 3;
constexpr double kRateStep = 0.04 * DriverBench::kPeriod;

/// Ready, and following a constant command where it stands.
void activate(DriverBench& bench) {
  ASSERT_TRUE(bench.initialise()) << bench.driver.report().reason;
  ASSERT_EQ(bench.command(bench.measured()), CommandVerdict::kAccepted) << bench.driver.report().reason;
  bench.cycle();
  ASSERT_EQ(bench.driver.report().state, DriverState::kActive);
}

/// Drives all cables to `goal` [m] from wherever they are.
void drive(DriverBench& bench, double goal, double time) {
  for (int n = 0; n < static_cast<int>(time / DriverBench::kPeriod); ++n) {
    bench.command(std::vector<double>(static_cast<std::size_t>(bench.bus.size()), goal));
    bench.cycle();
  }
}

TEST(HardwareDriver, EnableMovesNothing) {
  DriverBench bench(kServos);
  for (int i = 0; i < kServos; ++i)
    bench.bus.setShaftAngle(i, 0.3 * i - 4.0);  // slack: limp servos stay where they are
  bench.cycle();
  std::vector<double> before;
  for (int i = 0; i < kServos; ++i) before.push_back(bench.bus.shaftAngle(i));
  ASSERT_TRUE(bench.initialise()) << bench.driver.report().reason;
  bench.run(0.5);
  for (int i = 0; i < kServos; ++i) {
    EXPECT_TRUE(bench.bus.torqueEnabled(i));
    EXPECT_NEAR(bench.bus.shaftAngle(i), before[static_cast<std::size_t>(i)], 0.5 * kRadiansPerCount + 1e-9);
    EXPECT_TRUE(bench.driver.report().actuators[static_cast<std::size_t>(i)].zero_valid);
    EXPECT_EQ(bench.driver.report().actuators[static_cast<std::size_t>(i)].measured, 0);
  }
}

TEST(HardwareDriver, EnableUnderLoadHoldsWhatItMeasures) {
  DriverBench bench(kServos);
  ASSERT_TRUE(bench.initialise());
  std::vector<double> before;
  for (int i = 0; i < kServos; ++i) before.push_back(bench.bus.shaftAngle(i));
  bench.run(1);
  for (int i = 0; i < kServos; ++i)
    EXPECT_NEAR(bench.bus.shaftAngle(i), before[static_cast<std::size_t>(i)], kRadiansPerCount);
}

TEST(HardwareDriver, ConfiguresTheServos) {
  DriverBench bench(kServos);
  ASSERT_TRUE(bench.initialise());
  const SimulatedServo servo = bench.bus.servo(1);
  EXPECT_EQ(servo.value(servo_register::kOperatingMode), 5);
  EXPECT_EQ(servo.value(servo_register::kReturnDelay), 0);
  EXPECT_EQ(servo.value(servo_register::kBusWatchdog), 5);
  EXPECT_EQ(servo.value(servo_register::kGoalCurrent), 41);  // floor(20 N * 0.01 m / 1.7826 N m/A / 2.69 mA)
}

TEST(HardwareDriver, FollowsAtTheRateAndReportsWhatItApplied) {
  DriverBench bench(kServos);
  activate(bench);
  std::vector<double> last = bench.driver.report().applied;
  double largest_step = 0;
  for (int n = 0; n < 200; ++n) {
    bench.command({0.02, -0.01, 0.5});
    const DriverReport& r = bench.cycle();
    for (std::size_t i = 0; i < kServos; ++i) largest_step = std::max(largest_step, std::abs(r.applied[i] - last[i]));
    last = r.applied;
  }
  EXPECT_LE(largest_step, kRateStep * (1 + 1e-9));
  EXPECT_DOUBLE_EQ(last[0], 0.02);
  EXPECT_DOUBLE_EQ(last[1], -0.01);
  EXPECT_DOUBLE_EQ(last[2], 0.06) << "limited to the range";
  bench.run(0.05);
  EXPECT_NEAR(bench.displacement(0), 0.02, 2e-4);
}

TEST(HardwareDriver, FirstCommandMustEqualTheMeasurement) {
  DriverBench bench(kServos);
  ASSERT_TRUE(bench.initialise());
  EXPECT_EQ(bench.command({0, 0, 0.005}), CommandVerdict::kState);
  EXPECT_EQ(bench.driver.report().state, DriverState::kReady);
  EXPECT_NE(bench.cycle().reason.find("cable_3"), std::string::npos) << bench.driver.report().reason;
  EXPECT_EQ(bench.command({0, 0, 0.00009}), CommandVerdict::kAccepted);
  EXPECT_EQ(bench.cycle().state, DriverState::kActive);
}

TEST(HardwareDriver, LocksToOneSessionUntilRecovered) {
  DriverBench bench(kServos);
  activate(bench);
  EXPECT_EQ(bench.command(bench.measured(), CommandStatus::kOk, 8), CommandVerdict::kSession);
  bench.run(0.2);
  ASSERT_EQ(bench.driver.report().state, DriverState::kHolding);
  EXPECT_EQ(bench.command(bench.driver.report().applied, CommandStatus::kOk, 8), CommandVerdict::kSession);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  EXPECT_EQ(bench.command(bench.measured(), CommandStatus::kOk, 8), CommandVerdict::kAccepted);
  EXPECT_EQ(bench.cycle().state, DriverState::kActive);
  EXPECT_EQ(bench.driver.report().commands.session, 2u);
}

TEST(HardwareDriver, CommandLossHoldsThenRelaxes) {
  DriverBench bench(kServos);
  activate(bench);
  drive(bench, 0.01, 0.15);  // in mid-motion at the rate
  const Time lost = bench.line->now();
  const std::vector<double> held = bench.driver.report().applied;
  double to_holding = -1, to_safe = -1, to_limp = -1, largest_step = 0, drift = 0;
  double angle = bench.bus.shaftAngle(0);
  for (int n = 0; n < 200; ++n) {
    const DriverReport& r = bench.cycle();
    const double t = seconds(bench.line->now() - lost);
    if (r.state == DriverState::kHolding && to_holding < 0) {
      to_holding = t;
      for (std::size_t i = 0; i < held.size(); ++i) drift = std::max(drift, std::abs(r.applied[i] - 0.01));
      EXPECT_NE(r.reason.find("no command"), std::string::npos);
    }
    if (r.state == DriverState::kSafe && to_safe < 0) {
      to_safe = t;
      EXPECT_NE(r.reason.find("no command"), std::string::npos) << r.reason;
    }
    if (!bench.bus.torqueEnabled(0) && to_limp < 0) to_limp = t;
    largest_step = std::max(largest_step, std::abs(bench.bus.shaftAngle(0) - angle) * 0.01);
    angle = bench.bus.shaftAngle(0);
  }
  checkAtLeast("command_loss.hold_after_least", to_holding, 0.1 - 1e-6, "s");
  checkAtMost("command_loss.hold_after", to_holding, 0.1 + 2 * DriverBench::kPeriod, "s");
  checkAtLeast("command_loss.safe_after_least", to_safe - to_holding, 0.5 - 1e-6, "s");
  checkAtMost("command_loss.safe_after", to_safe - to_holding, 0.5 + 2 * DriverBench::kPeriod, "s");
  checkAtLeast("command_loss.limp_after_least", to_limp - to_safe, 0.4 - 1e-6, "s");
  checkAtMost("command_loss.limp_after", to_limp - to_safe, 0.4 + 3 * DriverBench::kPeriod, "s");
  checkAtMost("command_loss.largest_step", largest_step, kRateStep * 1.2, "m");
  EXPECT_LT(drift, 0.02);
  EXPECT_EQ(bench.driver.report().state, DriverState::kSafe) << "latched";
  EXPECT_EQ(bench.command(bench.measured()), CommandVerdict::kState);
}

TEST(HardwareDriver, ShortLossComesBackByItselfOnlyWithoutAJump) {
  DriverBench bench(kServos);
  activate(bench);
  bench.run(0.2);
  ASSERT_EQ(bench.driver.report().state, DriverState::kHolding);
  std::vector<double> near = bench.driver.report().applied, far = near;
  near[1] += 0.9 * kRateStep;
  far[1] += 1.5 * kRateStep;
  EXPECT_EQ(bench.command(far), CommandVerdict::kState);
  EXPECT_EQ(bench.cycle().state, DriverState::kHolding);
  EXPECT_NE(bench.driver.report().reason.find("recover"), std::string::npos);
  EXPECT_EQ(bench.command(near), CommandVerdict::kAccepted);
  EXPECT_EQ(bench.cycle().state, DriverState::kActive);
}

TEST(HardwareDriver, RecoverFromHoldingMovesNothing) {
  DriverBench bench(kServos);
  activate(bench);
  drive(bench, 0.02, 0.3);
  bench.run(0.3);
  ASSERT_EQ(bench.driver.report().state, DriverState::kHolding);
  const double angle = bench.bus.shaftAngle(0);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(0.5);
  EXPECT_EQ(bench.driver.report().state, DriverState::kReady);
  EXPECT_NEAR(bench.bus.shaftAngle(0), angle, kRadiansPerCount);
}

TEST(HardwareDriver, HeldForTooLongIsSafe) {
  DriverBench bench(kServos);
  activate(bench);
  int cycles = 0;
  while (bench.driver.report().state == DriverState::kActive && cycles < 1000) {
    bench.command(bench.driver.report().applied, CommandStatus::kHeld);
    bench.cycle();
    ++cycles;
  }
  EXPECT_EQ(bench.driver.report().state, DriverState::kSafe);
  EXPECT_NEAR(cycles * DriverBench::kPeriod, 0.5, 0.03);
}

TEST(HardwareDriver, HeldForAMomentIsNot) {
  DriverBench bench(kServos);
  activate(bench);
  for (int n = 0; n < 300; ++n) {
    const bool held = n % 40 < 35;
    bench.command(bench.driver.report().applied, held ? CommandStatus::kHeld : CommandStatus::kOk);
    ASSERT_EQ(bench.cycle().state, DriverState::kActive) << n;
  }
}

TEST(HardwareDriver, SafeRecoversWithItsZero) {
  DriverBench bench(kServos);
  activate(bench);
  drive(bench, 0.02, 0.6);
  bench.run(3);  // hold, relax, limp: the springs pull the cables out
  ASSERT_EQ(bench.driver.report().state, DriverState::kSafe);
  ASSERT_FALSE(bench.bus.torqueEnabled(0));
  const double angle = bench.bus.shaftAngle(0);
  ASSERT_LT(angle * 0.01, 0.019);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(1);
  ASSERT_EQ(bench.driver.report().state, DriverState::kReady) << bench.driver.report().reason;
  EXPECT_TRUE(bench.bus.torqueEnabled(0));
  EXPECT_NEAR(bench.bus.shaftAngle(0), angle, 2 * kRadiansPerCount) << "nothing moves on recovery";
  EXPECT_NEAR(bench.driver.report().actuators[0].measured, bench.displacement(0), 3e-5) << "the zero was kept";
}

TEST(HardwareDriver, HaltHoldsAndIsLatched) {
  DriverBench bench(kServos);
  activate(bench);
  drive(bench, 0.03, 0.3);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kHalt));
  bench.run(0.05);
  const double angle = bench.bus.shaftAngle(0);
  drive(bench, 0.03, 1);
  EXPECT_EQ(bench.driver.report().state, DriverState::kSafe);
  EXPECT_NEAR(bench.bus.shaftAngle(0), angle, 2 * kRadiansPerCount);
  EXPECT_TRUE(bench.bus.torqueEnabled(0));
  EXPECT_EQ(bench.bus.servo(0).value(servo_register::kBusWatchdog), 0xFF) << "the bus fell silent";
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(1);
  EXPECT_EQ(bench.driver.report().state, DriverState::kReady) << bench.driver.report().reason;
  EXPECT_NEAR(bench.bus.shaftAngle(0), angle, 2 * kRadiansPerCount) << "torque was not let go of in between";
}

TEST(HardwareDriver, DriverKilledLeavesTheServosToTheirWatchdog) {
  DriverBench bench(kServos);
  activate(bench);
  drive(bench, 0.05, 0.3);
  for (int n = 0; n < 30; ++n) bench.bus.step(0.01);  // no driver any more
  const double angle = bench.bus.shaftAngle(0);
  for (int n = 0; n < 100; ++n) bench.bus.step(0.01);
  EXPECT_EQ(bench.bus.servo(0).value(servo_register::kBusWatchdog), 0xFF);
  EXPECT_NEAR(bench.bus.shaftAngle(0), angle, kRadiansPerCount);
}

TEST(HardwareDriver, ShutdownRelaxesAndSwitchesOff) {
  DriverBench bench(kServos, "{method: present}", "hold");
  activate(bench);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kShutdown));
  EXPECT_TRUE(bench.driver.report().relaxing);
  bench.run(0.6);
  EXPECT_EQ(bench.driver.report().state, DriverState::kOff);
  EXPECT_FALSE(bench.driver.report().relaxing);
  for (int i = 0; i < kServos; ++i) EXPECT_FALSE(bench.bus.torqueEnabled(i));
}

TEST(HardwareDriver, SilentServoIsALatchedFault) {
  DriverBench bench(kServos);
  activate(bench);
  bench.bus.setFrozen(1, true);
  for (int n = 0; n < 30; ++n) {
    bench.command(bench.driver.report().applied);
    bench.cycle();
  }
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault);
  EXPECT_NE(bench.driver.report().reason.find("cable_2"), std::string::npos) << bench.driver.report().reason;
  bench.bus.setFrozen(1, false);
  bench.run(2);
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault) << "latched";
  EXPECT_NE(bench.driver.report().reason.find("call recover"), std::string::npos) << bench.driver.report().reason;
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(1);
  EXPECT_EQ(bench.driver.report().state, DriverState::kReady) << bench.driver.report().reason;
}

TEST(HardwareDriver, UnpluggedPortIsALatchedFaultAndTheLinkReturnsByItself) {
  DriverBench bench(kServos);
  activate(bench);
  bench.line->setPlugged(false);
  bench.port_exists = false;
  bench.run(1);
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault);
  EXPECT_FALSE(bench.driver.request(DriverRequest::kHalt));
  bench.line->setPlugged(true);
  bench.port_exists = true;
  bench.run(2);
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault);
  EXPECT_NE(bench.driver.report().reason.find("call recover"), std::string::npos) << bench.driver.report().reason;
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(1);
  EXPECT_EQ(bench.driver.report().state, DriverState::kReady) << bench.driver.report().reason;
}

TEST(HardwareDriver, InitWithoutAPortSaysWhy) {
  DriverBench bench(kServos);
  bench.port_exists = false;
  EXPECT_FALSE(bench.initialise());
  EXPECT_EQ(bench.driver.report().reason, "no such port");
}

TEST(HardwareDriver, PowerCycleLosesTheZero) {
  DriverBench bench(kServos);
  activate(bench);
  drive(bench, -0.02, 0.8);
  bench.bus.powerCycle(2);
  for (int n = 0; n < 30; ++n) {
    bench.command(bench.driver.report().applied);
    bench.cycle();
  }
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault);
  EXPECT_NE(bench.driver.report().reason.find("cable_3"), std::string::npos);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(1);
  ASSERT_EQ(bench.driver.report().state, DriverState::kReady) << bench.driver.report().reason;
  EXPECT_NEAR(bench.driver.report().actuators[0].measured, bench.displacement(0), 5e-5) << "kept";
  EXPECT_NEAR(bench.driver.report().actuators[2].measured, 0, 1e-6) << "homed anew where it was";
}

TEST(HardwareDriver, SupplyDipMakesTheZeroInvalid) {
  DriverBench bench(kServos);
  activate(bench);
  bench.bus.setSupplyVoltage(9.0);
  bench.run(0.05);
  bench.bus.setSupplyVoltage(12.0);
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault);
  EXPECT_FALSE(bench.driver.report().actuators[0].zero_valid);
  EXPECT_NE(bench.driver.report().reason.find("supply"), std::string::npos) << bench.driver.report().reason;
}

TEST(HardwareDriver, OverheatedServoIsAFaultThatOnlyARestartClears) {
  DriverBench bench(kServos);
  activate(bench);
  bench.bus.setTemperature(0, 95);
  bench.run(0.05);
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault);
  EXPECT_NE(bench.driver.report().actuators[0].fault & kOverheating, 0u);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(2);
  EXPECT_EQ(bench.driver.report().state, DriverState::kFault) << "still hot";
  bench.bus.setTemperature(0, 40);
  ASSERT_TRUE(bench.driver.request(DriverRequest::kRecover));
  bench.run(2);
  EXPECT_EQ(bench.driver.report().state, DriverState::kReady) << bench.driver.report().reason;
}

TEST(HardwareDriver, HomesToATension) {
  DriverBench bench(kServos, "{method: tension, tension: 5, speed: 0.01, travel: 0.04}");
  ASSERT_TRUE(bench.initialise()) << bench.driver.report().reason;
  for (int i = 0; i < kServos; ++i) {
    EXPECT_NEAR(bench.tension(i), 5, 0.6) << i;  // one unit of current is 0.48 N
    EXPECT_NEAR(bench.driver.report().actuators[static_cast<std::size_t>(i)].measured, 0, 1e-4);
  }
}

TEST(HardwareDriver, HomingGivesUpWithoutATension) {
  DriverBench bench(kServos, "{method: tension, tension: 15, speed: 0.02, travel: 0.01}");
  EXPECT_FALSE(bench.initialise());
  EXPECT_NE(bench.driver.report().reason.find("no tension"), std::string::npos) << bench.driver.report().reason;
}

TEST(HardwareDriver, TensionStaysBoundedByTheDevice) {
  DriverBench bench(1);
  bench.stiffness = 2000;  // 120 N at the end of the range
  activate(bench);
  double largest = 0;
  for (int n = 0; n < 400; ++n) {
    bench.command({0.06});
    bench.cycle();
    largest = std::max(largest, bench.tension(0));
  }
  checkAtMost("tension_bound.largest_tension", largest, 20, "N");
  EXPECT_GT(largest, 19) << "the bound is not wasted";
  EXPECT_EQ(bench.driver.report().applied[0], 0.06);
  EXPECT_LT(bench.driver.report().actuators[0].measured, 0.011) << "and the measurement tells where it really is";
}

/// s on a bad line: SINEW_SECONDS, 10 minutes where SINEW_FULL is set, or 60.
double readDuration() {
  if (const char* text = std::getenv("SINEW_SECONDS")) return std::atof(text);
  return std::getenv("SINEW_FULL") != nullptr ? 600 : 60;
}

/// A bad line, all servos moving: what was accepted is true, and what was injected is what was counted.
void runBadLine(const char* part, const LineFaults& faults, bool fast) {
  DriverBench bench(8);
  bench.bus.setFastSyncReadSupported(fast);
  activate(bench);
  for (int n = 0; n < 5; ++n) {  // settle on the kind of read that the devices know
    bench.command(bench.driver.report().applied);
    bench.cycle();
  }
  const BusCounters before = bench.driver.report().bus;
  bench.bus.setLineFaults(faults);
  const LineFaultCounts none = bench.bus.lineFaultCounts();
  std::uint64_t wrong = 0, accepted = 0;
  const int cycles = static_cast<int>(readDuration() / DriverBench::kPeriod);
  for (int n = 0; n < cycles; ++n) {
    const double t = n * DriverBench::kPeriod;
    std::vector<double> wanted;
    for (int i = 0; i < 8; ++i) wanted.push_back(0.01 * std::sin(2 * t + i) - 0.01 * std::sin(i));
    bench.command(wanted);
    std::vector<double> truth;
    for (int i = 0; i < 8; ++i) truth.push_back(bench.displacement(i));
    const DriverReport& r = bench.cycle();
    ASSERT_EQ(r.state, DriverState::kActive) << r.reason << " at " << t << " s";
    for (std::size_t i = 0; i < 8; ++i) {
      if (!r.actuators[i].valid) continue;
      ++accepted;
      if (std::abs(r.actuators[i].measured - truth[i]) > 1e-9) ++wrong;
    }
  }
  bench.bus.setLineFaults({});
  for (int n = 0; n < 10; ++n) {
    bench.command(bench.driver.report().applied);
    bench.cycle();
  }
  const LineFaultCounts injected = bench.bus.lineFaultCounts();
  const BusCounters counted = bench.driver.report().bus;
  const auto off = [](std::uint64_t a, std::uint64_t b) {
    return std::abs(static_cast<double>(a) - static_cast<double>(b));
  };
  const std::string prefix = std::string("servo_bus_faults.") + part;
  checkAtMost((prefix + "_wrong_values").c_str(), static_cast<double>(wrong), 0, "1");
  checkAtLeast((prefix + "_accepted_share").c_str(), static_cast<double>(accepted) / (8.0 * cycles), fast ? 0.9 : 0.95,
               "1");
  checkAtMost((prefix + "_corrupted_miscounted").c_str(),
              off(counted.corrupted - before.corrupted, injected.corrupted - none.corrupted), 0, "1");
  checkAtMost((prefix + "_missing_miscounted").c_str(),
              off(counted.missing - before.missing, injected.dropped + injected.delayed - none.dropped - none.delayed),
              0, "1");
  checkAtMost((prefix + "_stale_miscounted").c_str(),
              off(counted.stale - before.stale, injected.delayed - none.delayed), 0, "1");
  std::printf(
      "injected: %llu corrupted, %llu dropped, %llu delayed of %llu\n",
      static_cast<unsigned long long>(injected.corrupted), static_cast<unsigned long long>(injected.dropped),
      static_cast<unsigned long long>(injected.delayed),
      static_cast<unsigned long long>(injected.sent + injected.corrupted + injected.dropped + injected.delayed));
  EXPECT_GT(static_cast<double>(injected.corrupted - none.corrupted), 0.005 * cycles);
}

LineFaults makeFaults(double delay_time) {
  LineFaults faults;
  faults.corrupt = faults.drop = faults.delay = 0.01;
  faults.delay_time = delay_time;
  faults.seed = 20240607;
  return faults;
}

TEST(HardwareDriver, BadLineWithOneAnswerPerServo) {
  runBadLine("single", makeFaults(0.0137), false);
}

TEST(HardwareDriver, BadLineWithLongDelays) {
  runBadLine("long_delay", makeFaults(0.0512), false);
}

TEST(HardwareDriver, BadLineWithJointAnswers) {
  runBadLine("joint", makeFaults(0.0137), true);
}

TEST(HardwareDriver, SurvivesAVeryBadLine) {
  DriverBench bench(8);
  activate(bench);
  LineFaults faults = makeFaults(0.0093);
  faults.corrupt = faults.drop = faults.delay = 0.15;
  bench.bus.setLineFaults(faults);
  bench.bus.setFastSyncReadSupported(false);
  std::uint64_t wrong = 0;
  for (int n = 0; n < 2000 && bench.driver.report().state == DriverState::kActive; ++n) {
    bench.command(std::vector<double>(8, 0.01 * std::sin(0.03 * n)));
    std::vector<double> truth;
    for (int i = 0; i < 8; ++i) truth.push_back(bench.displacement(i));
    const DriverReport& r = bench.cycle();
    for (std::size_t i = 0; i < 8; ++i)
      if (r.actuators[i].valid && std::abs(r.actuators[i].measured - truth[i]) > 1e-9) ++wrong;
  }
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace sinew
