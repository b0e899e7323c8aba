#pragma once

#include <cstdint>
#include <vector>

#include "sinew/hardware/dynamixel_packet.h"
#include "sinew/hardware/simulated_serial_bus.h"
#include "sinew/hardware/simulated_servo.h"

namespace sinew {

/// A daisy chain of simulated Dynamixel servos on one half-duplex line. The mechanics are stepped from outside:
///
///   PseudoTerminal terminal("/tmp/sinew_servos");       // the driver opens this path as its port
///   SimulatedServoBus bus({1, 2, 3, 4, 5, 6, 7, 8});
///   bus.start(terminal);                                // answers packets from its own thread
///   every dt:  bus.setLoadTorque(i, -tension * radius); // per servo, from the mechanics
///              bus.step(dt);
///              length_pulled_in = radius * (bus.shaftAngle(i) - angle_at_zero);
///
/// Servos are addressed by index 0 .. size()-1, in the order of the ids given. Every member may be called from any
/// thread.
class SimulatedServoBus : public SimulatedSerialBus {
 public:
  /// `ids`: bus ids, each once, 0 .. 252. `baud` sets the time that packets spend on the line.
  explicit SimulatedServoBus(const std::vector<std::uint8_t>& ids, int baud = 1000000,
                             const SimulatedServo::Parameters& parameters = {});
  /// Servos of different models.
  SimulatedServoBus(const std::vector<std::uint8_t>& ids, int baud,
                    const std::vector<SimulatedServo::Parameters>& parameters);
  ~SimulatedServoBus() override { stop(); }
  SimulatedServoBus(const SimulatedServoBus&) = delete;
  SimulatedServoBus& operator=(const SimulatedServoBus&) = delete;

  int size() const override { return static_cast<int>(servos_.size()); }

  // --- Mechanics ---

  /// Torque [N m] that the load exerts on the shaft of `servo`, positive towards increasing angle. A cable under
  /// tension T on a spool of radius r that reels in with positive rotation exerts -T r. Kept until set again.
  void setLoadTorque(int servo, double torque) override;
  /// Shaft angle [rad], continuous over turns, positive counter-clockwise as the device counts. Starts at 0.
  double shaftAngle(int servo) const override;
  /// Turns the shaft by hand to `angle` [rad].
  void setShaftAngle(int servo, double angle);
  /// Torque [N m] that the motor exerted over the last step, same sign as the angle.
  double motorTorque(int servo) const;
  bool torqueEnabled(int servo) const;
  bool energised(int servo) const override;
  double pressure(int /*servo*/) const override { return 0; }
  /// Moves every shaft on by `dt` [s]: profiles, current limits, bus watchdog, alarms. The simulated time of the servos
  /// is the sum of the steps.
  void step(double dt) override;

  // --- Faults on request ---

  /// A frozen servo neither answers nor moves.
  void setFrozen(int servo, bool frozen) override;
  /// Temperature [degC]; above the servo's limit it raises the overheating alarm and shuts its motor down.
  void setTemperature(int servo, double temperature) override;
  /// Supply [V] of every servo. Below the minimum voltage limit they raise the voltage alarm; below the brown-out
  /// voltage they are off, and restart (torque off, multi-turn count lost) when it returns.
  void setSupplyVoltage(double voltage) override;
  /// Switches one servo off and on again: RAM back to its defaults, multi-turn count lost.
  void powerCycle(int servo) override;
  void setLeak(int /*servo*/, double /*rate*/) override {}
  /// Whether the devices know instruction 8A; older firmware answers it with an error.
  void setFastSyncReadSupported(bool supported);
  /// A copy of one servo, for checks that look inside.
  SimulatedServo servo(int servo) const;

 private:
  void take(const std::uint8_t* data, std::size_t size, Time now) override;
  void handle(const InstructionView& packet, Time received);
  void answerSyncRead(const InstructionView& packet, Time received);
  void answerFastSyncRead(const InstructionView& packet, Time received);
  void applySyncWrite(const InstructionView& packet);
  SimulatedServo* find(std::uint8_t id);

  std::vector<SimulatedServo> servos_;
  bool fast_sync_read_ = true;
  PacketReader reader_;
};

}  // namespace sinew
