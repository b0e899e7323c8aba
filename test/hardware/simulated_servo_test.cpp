#include "sinew/hardware/simulated_servo.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew {
namespace {

namespace reg = servo_register;

constexpr double kNewtonMetresPerUnit = kAmperesPerUnit * 4.1 / 2.3;

struct Bench {
  SimulatedServo servo{1, SimulatedServo::Parameters{}};

  ServoError write(ServoRegister r, std::int32_t value) {
    std::uint8_t data[4];
    encodeRegister(value, r.size, data);
    return servo.write(r.address, data, r.size);
  }
  std::int32_t read(ServoRegister r) {
    std::uint8_t data[4] = {};
    EXPECT_EQ(servo.read(r.address, r.size, data), ServoError::kNone);
    return decodeRegister(data, r.size);
  }
  void enable(OperatingMode mode) {
    ASSERT_EQ(write(reg::kOperatingMode, static_cast<int>(mode)), ServoError::kNone);
    ASSERT_EQ(write(reg::kTorqueEnable, 1), ServoError::kNone);
  }
  void run(double time) {
    for (int n = 0; n < static_cast<int>(time / 0.001 + 0.5); ++n) {
      servo.feedWatchdog();
      servo.step(0.001);
    }
  }
};

TEST(SimulatedServo, StartsWithTheFactoryTable) {
  Bench b;
  EXPECT_EQ(b.read(reg::kModelNumber), 1020);
  EXPECT_EQ(b.read(reg::kId), 1);
  EXPECT_EQ(b.read(reg::kReturnDelay), 250);
  EXPECT_EQ(b.read(reg::kOperatingMode), 3);
  EXPECT_EQ(b.read(reg::kShutdown), 52);
  EXPECT_EQ(b.read(reg::kCurrentLimit), 1193);
  EXPECT_EQ(b.read(reg::kPresentVoltage), 120);
  EXPECT_EQ(b.read(reg::kTorqueEnable), 0);
  EXPECT_EQ(b.read(reg::kBusWatchdog), 0);
}

TEST(SimulatedServo, AccessRules) {
  Bench b;
  EXPECT_EQ(b.write(reg::kModelNumber, 5), ServoError::kAccess) << "read only";
  EXPECT_EQ(b.write({66, 1}, 5), ServoError::kAccess) << "not defined";
  EXPECT_EQ(b.write(reg::kOperatingMode, 2), ServoError::kDataRange);
  EXPECT_EQ(b.write(reg::kOperatingMode, 17), ServoError::kDataRange);
  EXPECT_EQ(b.write({116, 2}, 100), ServoError::kDataLength) << "half of a register";
  EXPECT_EQ(b.write(reg::kGoalPosition, 5000), ServoError::kDataLimit) << "beyond the position limit of mode 3";
  EXPECT_EQ(b.write(reg::kOperatingMode, 4), ServoError::kNone);
  EXPECT_EQ(b.write(reg::kGoalPosition, 5000), ServoError::kNone) << "several turns";
  EXPECT_EQ(b.write(reg::kGoalPosition, kMaxGoalPosition + 1), ServoError::kDataRange);
  EXPECT_EQ(b.write(reg::kCurrentLimit, 100), ServoError::kNone);
  EXPECT_EQ(b.write(reg::kGoalCurrent, 101), ServoError::kDataLimit);
  EXPECT_EQ(b.write(reg::kTorqueEnable, 1), ServoError::kNone);
  EXPECT_EQ(b.write(reg::kOperatingMode, 3), ServoError::kAccess) << "locked while the torque is on";
  EXPECT_EQ(b.write(reg::kGoalCurrent, 50), ServoError::kNone);
}

TEST(SimulatedServo, ARefusedWriteChangesNothing) {
  Bench b;
  std::uint8_t data[6] = {};
  encodeRegister(50, 2, data);         // goal current: fine
  encodeRegister(99999, 4, data + 2);  // goal velocity: not
  EXPECT_NE(b.servo.write(reg::kGoalCurrent.address, data, 6), ServoError::kNone);
  EXPECT_EQ(b.read(reg::kGoalCurrent), 1193);
}

TEST(SimulatedServo, LimpUntilTheTorqueIsOn) {
  Bench b;
  b.servo.setLoadTorque(-0.005);
  b.run(0.1);
  EXPECT_EQ(b.servo.shaftAngle(), 0) << "held by the friction of its gear";
  b.servo.setLoadTorque(-0.006);
  b.run(0.1);
  EXPECT_NEAR(b.servo.shaftAngle(), -0.01, 1e-9) << "dragged against damping and friction";
  b.write(reg::kGoalPosition, b.read(reg::kPresentPosition));
  b.enable(OperatingMode::kExtendedPosition);
  const double angle = b.servo.shaftAngle();
  b.run(0.5);
  EXPECT_NEAR(b.servo.shaftAngle(), angle, 0.51 * kRadiansPerCount);
  b.write(reg::kTorqueEnable, 0);
  b.run(0.1);
  EXPECT_LT(b.servo.shaftAngle(), angle - 0.009);
}

TEST(SimulatedServo, StaleGoalMovesTheShaftOnEnable) {
  Bench b;
  b.write(reg::kOperatingMode, 4);
  b.write(reg::kGoalPosition, 2000);
  b.run(0.2);
  EXPECT_EQ(b.read(reg::kPresentPosition), 0);
  b.write(reg::kTorqueEnable, 1);
  b.run(2);
  EXPECT_EQ(b.read(reg::kPresentPosition), 2000);
}

TEST(SimulatedServo, TrapezoidTakesItsTime) {
  Bench b;
  b.enable(OperatingMode::kExtendedPosition);
  const int velocity = 100, acceleration = 40, counts = 4096;
  b.write(reg::kProfileVelocity, velocity);
  b.write(reg::kProfileAcceleration, acceleration);
  b.write(reg::kGoalPosition, counts);
  const double v = velocity * kRadiansPerSecondPerUnit, a = acceleration * kRadiansPerSecond2PerUnit;
  const double expected = counts * kRadiansPerCount / v + v / a;  // the time of a trapezoid
  double t = 0, fastest = 0, last = 0;
  for (; b.read(reg::kPresentPosition) < counts - 1 && t < 20; t += 0.001) {
    b.run(0.001);
    fastest = std::max(fastest, (b.servo.shaftAngle() - last) / 0.001);
    last = b.servo.shaftAngle();
  }
  EXPECT_NEAR(t, expected, 0.06 * expected);
  EXPECT_NEAR(fastest, v, 0.01 * v);
  b.run(1);
  EXPECT_EQ(b.read(reg::kPresentPosition), counts);
  EXPECT_EQ(b.read(reg::kMoving), 0);
}

TEST(SimulatedServo, TrapezoidDoesNotDependOnTheStep) {
  double end[2];
  for (const int k : {0, 1}) {
    Bench b;
    b.enable(OperatingMode::kExtendedPosition);
    b.write(reg::kProfileVelocity, 50);
    b.write(reg::kProfileAcceleration, 20);
    b.write(reg::kGoalPosition, 3000);
    for (int n = 0; n < (k == 0 ? 500 : 50); ++n) b.servo.step(k == 0 ? 0.001 : 0.01);
    end[k] = b.servo.shaftAngle();
  }
  EXPECT_NEAR(end[0], end[1], 1e-9);
}

TEST(SimulatedServo, SupplySetsTheTopSpeed) {
  Bench b;
  b.enable(OperatingMode::kExtendedPosition);
  b.write(reg::kGoalPosition, 100000);
  b.run(1);
  EXPECT_NEAR(b.servo.shaftAngle(), 46 * 2 * kPi / 60, 0.05);
}

TEST(SimulatedServo, PositionModeStaysWithinOneTurn) {
  Bench b;
  b.enable(OperatingMode::kPosition);
  EXPECT_EQ(b.write(reg::kGoalPosition, 4095), ServoError::kNone);
  EXPECT_EQ(b.write(reg::kGoalPosition, 4096), ServoError::kDataLimit);
  EXPECT_EQ(b.write(reg::kGoalPosition, -1), ServoError::kDataLimit);
  b.run(2);
  EXPECT_EQ(b.read(reg::kPresentPosition), 4095);
}

TEST(SimulatedServo, GoalCurrentBoundsTheTorqueInMode5) {
  Bench b;
  b.enable(OperatingMode::kCurrentBasedPosition);
  b.write(reg::kGoalCurrent, 40);
  b.servo.setLoadTorque(-39 * kNewtonMetresPerUnit);
  b.run(0.5);
  EXPECT_EQ(b.read(reg::kPresentPosition), 0) << "holds below the bound";
  EXPECT_EQ(b.read(reg::kPresentCurrent), 39);
  b.servo.setLoadTorque(-45 * kNewtonMetresPerUnit);
  b.run(0.05);
  EXPECT_LT(b.servo.shaftAngle(), -0.05) << "gives way above it";
  EXPECT_EQ(b.read(reg::kPresentCurrent), 40);
  b.write(reg::kGoalCurrent, 60);
  b.run(0.5);
  EXPECT_EQ(b.read(reg::kPresentPosition), 0);
}

TEST(SimulatedServo, CurrentVelocityAndPwmModes) {
  {
    Bench b;
    b.enable(OperatingMode::kCurrent);
    b.write(reg::kGoalCurrent, 10);
    b.servo.setLoadTorque(-8 * kNewtonMetresPerUnit);
    b.run(0.1);
    EXPECT_NEAR(b.servo.shaftAngle(), 2 * kNewtonMetresPerUnit / 0.01 * 0.1, 1e-9);
  }
  {
    Bench b;
    b.enable(OperatingMode::kVelocity);
    b.write(reg::kGoalVelocity, -100);
    b.run(1);
    EXPECT_NEAR(b.servo.shaftAngle(), -100 * kRadiansPerSecondPerUnit, 1e-3);
    EXPECT_EQ(b.read(reg::kPresentVelocity), -100);
  }
  {
    Bench b;
    b.enable(OperatingMode::kPwm);
    b.write(reg::kGoalPwm, 442);
    b.run(1);
    EXPECT_NEAR(b.servo.shaftAngle(), 0.5 * 46 * 2 * kPi / 60, 0.05);
  }
}

TEST(SimulatedServo, ReverseModeTurnsTheOtherWay) {
  Bench b;
  b.write(reg::kDriveMode, 1);
  b.enable(OperatingMode::kExtendedPosition);
  b.write(reg::kGoalPosition, 1000);
  b.run(2);
  EXPECT_EQ(b.read(reg::kPresentPosition), 1000);
  EXPECT_NEAR(b.servo.shaftAngle(), -1000 * kRadiansPerCount, 1e-6);
}

TEST(SimulatedServo, BusWatchdogStopsAndLocksTheGoals) {
  Bench b;
  b.enable(OperatingMode::kExtendedPosition);
  b.write(reg::kProfileVelocity, 50);
  b.write(reg::kGoalPosition, 100000);
  b.write(reg::kBusWatchdog, 5);
  b.run(0.5);
  EXPECT_EQ(b.read(reg::kBusWatchdog), 5) << "fed";
  for (int n = 0; n < 98; ++n) b.servo.step(0.001);
  EXPECT_EQ(b.read(reg::kBusWatchdog), 5);
  for (int n = 0; n < 5; ++n) b.servo.step(0.001);
  EXPECT_EQ(b.read(reg::kBusWatchdog), 0xFF);
  const double angle = b.servo.shaftAngle();
  b.run(0.5);
  EXPECT_NEAR(b.servo.shaftAngle(), angle, kRadiansPerCount) << "stopped, though fed again";
  EXPECT_EQ(b.read(reg::kTorqueEnable), 1);
  for (const ServoRegister r : {reg::kGoalPosition, reg::kGoalCurrent, reg::kGoalVelocity, reg::kGoalPwm})
    EXPECT_EQ(b.write(r, 5), ServoError::kDataRange);
  EXPECT_EQ(b.write(reg::kBusWatchdog, 5), ServoError::kDataRange);
  EXPECT_EQ(b.write(reg::kBusWatchdog, 0), ServoError::kNone);
  EXPECT_EQ(b.write(reg::kGoalPosition, 5), ServoError::kNone);
}

TEST(SimulatedServo, WatchdogSleepsWhileLimp) {
  Bench b;
  b.write(reg::kBusWatchdog, 1);
  for (int n = 0; n < 1000; ++n) b.servo.step(0.001);
  EXPECT_EQ(b.read(reg::kBusWatchdog), 1);
}

TEST(SimulatedServo, OverheatingShutsDownUntilReboot) {
  Bench b;
  b.enable(OperatingMode::kExtendedPosition);
  EXPECT_EQ(b.servo.errorField(ServoError::kNone), 0);
  b.servo.setTemperature(81);
  b.run(0.01);
  EXPECT_EQ(b.read(reg::kHardwareError), kOverheating);
  EXPECT_EQ(b.servo.errorField(ServoError::kNone), kAlertBit);
  EXPECT_EQ(b.read(reg::kTorqueEnable), 0);
  b.servo.setTemperature(40);
  b.run(0.01);
  EXPECT_EQ(b.write(reg::kTorqueEnable, 1), ServoError::kResultFail);
  b.servo.reboot();
  EXPECT_EQ(b.read(reg::kHardwareError), 0);
  EXPECT_EQ(b.write(reg::kTorqueEnable, 1), ServoError::kNone);
}

TEST(SimulatedServo, VoltageAlarmDoesNotShutDownByDefault) {
  Bench b;
  b.enable(OperatingMode::kExtendedPosition);
  b.servo.setSupplyVoltage(9.4);
  b.run(0.01);
  EXPECT_EQ(b.read(reg::kHardwareError), kVoltageError);
  EXPECT_EQ(b.read(reg::kTorqueEnable), 1);
  EXPECT_EQ(b.read(reg::kPresentVoltage), 94);
}

TEST(SimulatedServo, PowerLossForgetsTheTurnsAndTheRam) {
  Bench b;
  b.write(reg::kReturnDelay, 0);
  b.servo.setShaftAngle(2 * kPi * 3.25);
  EXPECT_EQ(b.read(reg::kPresentPosition), 3 * 4096 + 1024);
  b.write(reg::kGoalCurrent, 50);
  b.servo.setSupplyVoltage(3);
  EXPECT_FALSE(b.servo.answers());
  b.servo.setSupplyVoltage(12);
  EXPECT_TRUE(b.servo.answers());
  EXPECT_EQ(b.read(reg::kPresentPosition), 1024);
  EXPECT_EQ(b.read(reg::kGoalCurrent), 1193);
  EXPECT_EQ(b.read(reg::kReturnDelay), 0) << "EEPROM";
  EXPECT_EQ(b.read(reg::kGoalPosition), 1024);
}

TEST(SimulatedServo, ClearBringsThePositionIntoOneTurn) {
  Bench b;
  const std::uint8_t key[] = {0x01, 0x44, 0x58, 0x4C, 0x22};
  b.servo.setShaftAngle(-2 * kPi * 2.5);
  EXPECT_EQ(b.servo.clear(key, 4), ServoError::kDataRange);
  EXPECT_EQ(b.servo.clear(key, 5), ServoError::kNone);
  EXPECT_EQ(b.read(reg::kPresentPosition), 2048);
}

TEST(SimulatedServo, RegisteredWriteWaitsForAction) {
  Bench b;
  const std::uint8_t data[] = {7, 0};
  EXPECT_EQ(b.servo.action(), ServoError::kInstruction);
  EXPECT_EQ(b.servo.regWrite(reg::kGoalCurrent.address, data, 2), ServoError::kNone);
  EXPECT_EQ(b.read(reg::kRegisteredInstruction), 1);
  EXPECT_EQ(b.read(reg::kGoalCurrent), 1193);
  EXPECT_EQ(b.servo.action(), ServoError::kNone);
  EXPECT_EQ(b.read(reg::kGoalCurrent), 7);
}

TEST(SimulatedServo, IndirectAddressesGatherRegisters) {
  Bench b;
  b.servo.setShaftAngle(1000 * kRadiansPerCount);
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(b.write({static_cast<std::uint16_t>(168 + 2 * i), 2}, 132 + i), ServoError::kNone);
  EXPECT_EQ(b.read({224, 4}), 1000);
  b.write(reg::kTorqueEnable, 1);
  EXPECT_EQ(b.write({168, 2}, 100), ServoError::kAccess);
  b.servo.reboot();
  EXPECT_EQ(b.read({224, 4}), 0) << "forgotten";
}

TEST(SimulatedServo, TickCountsMilliseconds) {
  Bench b;
  b.servo.setMilliseconds(100000);
  b.servo.reboot();
  b.servo.setMilliseconds(100000 + kTickPeriod + 17);
  EXPECT_EQ(b.read(reg::kRealtimeTick), 17);
}

TEST(SimulatedServo, FrozenNeitherAnswersNorMoves) {
  Bench b;
  b.servo.setLoadTorque(-1);
  b.servo.setFrozen(true);
  b.run(0.1);
  EXPECT_FALSE(b.servo.answers());
  EXPECT_EQ(b.servo.shaftAngle(), 0);
}

}  // namespace
}  // namespace sinew
