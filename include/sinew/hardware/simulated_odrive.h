#pragma once

#include <cstdint>
#include <vector>

#include "sinew/hardware/simulated_can_node.h"

namespace sinew {

/// One ODrive axis as seen over CAN Simple, with the spool that its motor turns. Mechanics are quasi-static,
///   damping * omega = motor torque + load torque - friction of a limp shaft,
/// with the motor torque bounded by the current limit, and all of it at the spool's shaft. Angles of the shaft are the
/// spool's; the encoder counts turns of the motor from where it was switched on. It shares no code with the
/// driver's side.
class SimulatedOdrive : public SimulatedCanNode {
 public:
  struct Parameters {
    bool firmware05 = false;       ///< speaks like firmware 0.5
    double gear_ratio = 1;         ///< turns of the motor for one of the spool
    double torque_constant = 0.5;  ///< N m/A at the spool's shaft
    double current_max = 20;       ///< A, limit after a restart
    double speed_max = 30;         ///< rad/s of the spool that the supply allows
    double damping = 0.01;         ///< N m s/rad
    double friction = 0.005;       ///< N m that a limp gear holds before a load drags it
    double response_time = 0.005;  ///< s with which the shaft follows its set point
    double supply = 24;            ///< V
    double undervoltage = 10.5;    ///< V below which the axis disarms
    double brown_out = 8;          ///< V below which the electronics stop
    double temperature_max = 100;  ///< degC above which the axis disarms
    double boot_time = 0.8;        ///< s of silence after a restart
    double heartbeat = 0.1;        ///< s
    double cyclic = 0;             ///< s between messages of estimates and currents that are sent unasked; 0 for none
    // What save_configuration() has kept
    bool watchdog_enabled = true;
    double watchdog_timeout = 0.1;      ///< s
    bool watchdog_idle = true;          ///< whether the watchdog acts in an idle axis too
    std::uint16_t enable_endpoint = 0;  ///< 0 for none that can be reached
    std::uint16_t timeout_endpoint = 0;
  };

  SimulatedOdrive(int node, const Parameters& parameters);

  int size() const override { return 1; }
  void take(const CanFrame& frame, Time now, std::vector<CanFrame>& out) override;
  void update(Time now, std::vector<CanFrame>& out) override;

  void step(double dt) override;
  void setLoadTorque(int i, double torque) override;
  double shaftAngle(int i) const override;
  double pressure(int i) const override;
  bool energised(int i) const override;
  void setFrozen(bool frozen) override { frozen_ = frozen; }
  void setTemperature(double temperature) override { temperature_ = temperature; }
  void setSupplyVoltage(double voltage) override;
  void powerCycle() override { restart(); }
  void setLeak(int i, double rate) override;

  void setShaftAngle(double angle);  ///< rad, turned by hand
  /// Raises an error, as a failing encoder or motor would.
  void raise(std::uint32_t error);
  int state() const { return state_; }
  std::uint32_t error() const { return error_; }
  double currentLimit() const { return current_limit_; }        ///< A
  double velocityLimit() const { return velocity_limit_; }      ///< turn/s
  double motorTorque() const { return torque_; }                ///< N m
  double watchdogTimeout() const { return watchdog_timeout_; }  ///< s, 0 when it is not enabled
  int inputMode() const { return input_mode_; }

 private:
  void boot();
  void restart();
  void disarm(std::uint32_t error);
  void obey(int command, const CanFrame& frame, std::vector<CanFrame>& out);
  void answer(int command, std::vector<CanFrame>& out);
  void accessEndpoint(const CanFrame& frame, std::vector<CanFrame>& out);
  void requestState(std::uint32_t state);
  void substep(double dt);
  double calcWantedSpeed(double dt);
  double turnsOf(double angle) const;
  double angleOf(double turns) const;
  double current() const { return torque_ / parameters_.torque_constant; }
  bool alive() const { return powered_ && !frozen_ && !starting_; }

  int node_;
  Parameters parameters_;
  bool powered_ = true, frozen_ = false, starting_ = false;
  Time start_at_{};
  double voltage_, temperature_ = 30;
  double angle_ = 0, omega_ = 0, torque_ = 0, load_ = 0;
  double boot_angle_ = 0;

  // What a restart forgets
  int state_ = 1;
  std::uint32_t error_ = 0, disarm_reason_ = 0;
  int control_mode_ = 3, input_mode_ = 1;
  double input_pos_ = 0;                                                          // turns
  double velocity_limit_ = 0, current_limit_ = 0;                                 // turn/s, A
  double profile_speed_ = 2, profile_acceleration_ = 0.5, profile_velocity_ = 0;  // turn/s, turn/s2, turn/s
  double profile_position_ = 0;                                                   // turns
  double watchdog_timeout_ = 0, watchdog_setting_ = 0;                            // s
  bool watchdog_enabled_ = false;
  Time fed_at_{}, beat_at_{}, cyclic_at_{};
};

}  // namespace sinew
