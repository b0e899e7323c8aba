#pragma once

#include <array>
#include <cstdint>

#include "sinew/hardware/dynamixel_packet.h"
#include "sinew/hardware/servo_registers.h"

namespace sinew {

/// One Dynamixel X (an XM430-W350 unless told otherwise) as seen over its bus: the control table with its access rules,
/// the motion it commands, and the alarms. Mechanics are quasi-static,
///   damping * omega = motor torque + load torque - friction of a limp shaft,
/// with the motor torque bounded by the goal current (mode 5) or the current limit, the supply and the PWM limit. Time
/// passes only in `step()`, except for the millisecond clock of the line side.
class SimulatedServo {
 public:
  struct Parameters {
    double torque_constant = 4.1 / 2.3;        ///< N m/A at the shaft: stall torque over stall current at 12 V
    double stall_torque = 4.1;                 ///< N m at the nominal voltage
    double no_load_speed = 46 * 2 * kPi / 60;  ///< rad/s at the nominal voltage
    double damping = 0.01;                     ///< N m s/rad of the gear, the speed at which a load drags a limp shaft
    double friction = 0.005;                   ///< N m that the gear of a limp shaft holds before a load drags it
    double response_time = 0.005;              ///< s, time constant with which the shaft follows its profile
    double brown_out = 7;                      ///< V of supply below which the electronics stop
    std::uint8_t firmware = 45;
    std::uint16_t model = kModelXm430W350;
    double amperes_per_unit = kAmperesPerUnit;  ///< of its current registers
    int current_limit = 1193;                   ///< factory value and most, in those units
    int min_voltage = 95, max_voltage = 160;    ///< 0.1 V, factory limits
    double voltage = 12;                        ///< V nominal, at which torque and speed are stated
    std::uint16_t indirect_data = 224;          ///< address of the first byte seen through indirect addresses
    std::uint16_t indirect_count = 28;          ///< indirect addresses from 168 on

    /// A small servo for 5 V whose control table ends early (e-Manual, XL330-M288).
    static Parameters makeXl330M288();
  };

  explicit SimulatedServo(std::uint8_t id, const Parameters& parameters);

  // --- The bus side ---
  std::uint8_t id() const { return memory_[servo_register::kId.address]; }
  bool answers() const { return powered_ && !frozen_; }
  ServoError read(std::size_t address, std::size_t size, std::uint8_t* data);
  ServoError write(std::size_t address, const std::uint8_t* data, std::size_t size);
  ServoError regWrite(std::size_t address, const std::uint8_t* data, std::size_t size);
  ServoError action();
  ServoError clear(const std::uint8_t* parameters, std::size_t size);
  void reboot();
  /// Any instruction packet on the bus restarts the bus watchdog's wait.
  void feedWatchdog() { idle_time_ = 0; }
  /// Error field of a status packet: `error` with the alert bit.
  std::uint8_t errorField(ServoError error) const;
  /// The device's millisecond clock, counted by the line side.
  void setMilliseconds(std::int64_t ms);
  std::int32_t value(ServoRegister r) const;

  // --- The mechanical side ---
  void step(double dt);
  void setLoadTorque(double torque) { load_ = torque; }
  void setShaftAngle(double angle);
  double shaftAngle() const { return angle_; }
  double motorTorque() const { return torque_; }
  /// Torque on, and not stopped by its bus watchdog.
  bool energised() const { return powered_ && torqueEnabled() && !watchdogTripped(); }
  bool torqueEnabled() const { return memory_[servo_register::kTorqueEnable.address] != 0; }

  // --- Faults ---
  void setFrozen(bool frozen) { frozen_ = frozen; }
  void setTemperature(double temperature) { temperature_ = temperature; }
  void setSupplyVoltage(double voltage);

 private:
  struct Motion {
    double position = 0;  // rad, of the shaft
    double velocity = 0;  // rad/s
  };
  void boot();
  void set(ServoRegister r, std::int32_t value);
  void resetGoals();
  ServoError checkWrite(std::size_t address, const std::uint8_t* data, std::size_t size) const;
  ServoError checkValue(ServoRegister r, std::int32_t value) const;
  void applyWrite(ServoRegister r, std::int32_t value);
  void refreshPresent();
  std::size_t resolve(std::size_t address) const;
  bool inIndirectAddresses(std::size_t address) const;
  bool watchdogTripped() const { return memory_[servo_register::kBusWatchdog.address] == 0xFF; }
  int direction() const { return (memory_[servo_register::kDriveMode.address] & 1) != 0 ? -1 : 1; }
  OperatingMode mode() const { return static_cast<OperatingMode>(memory_[servo_register::kOperatingMode.address]); }
  int toCounts(double angle) const;
  double toAngle(int counts) const;
  double torqueLimit() const;
  double maxSpeed() const { return parameters_.no_load_speed * voltage_ / parameters_.voltage; }
  double calcMotorTorque(double dt) const;
  void updateProfile(double dt);
  void updateWatchdog(double dt);
  void updateAlarms();
  void substep(double dt);

  static constexpr std::size_t kTableSize = 662;
  Parameters parameters_;
  std::array<std::uint8_t, kTableSize> memory_{};
  std::array<std::uint8_t, 32> registered_{};  // address, size and data of a reg write
  std::size_t registered_size_ = 0;
  std::size_t registered_address_ = 0;
  double angle_ = 0, omega_ = 0, torque_ = 0, load_ = 0;  // rad, rad/s, N m, N m
  Motion profile_;
  int zero_count_ = 0;  // encoder counts, whole turns, lost at power-off
  double idle_time_ = 0;
  std::int64_t milliseconds_ = 0, boot_milliseconds_ = 0;
  double temperature_ = 30, voltage_ = 0;
  bool powered_ = true, frozen_ = false;
};

}  // namespace sinew
