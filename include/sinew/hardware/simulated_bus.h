#pragma once

#include "sinew/hardware/line_faults.h"

namespace sinew {

class ByteStream;

/// Devices that stand in for those of a `DeviceBus`, on a line that answers like theirs. The mechanics of what they
/// move are stepped from outside. Actuators are numbered as on the bus of the hardware description. Every member may be
/// called from any thread.
class SimulatedBus {
 public:
  virtual ~SimulatedBus() = default;

  virtual int size() const = 0;

  /// Answers on `line`, which must live until `stop()`, from a thread of its own.
  virtual void start(ByteStream& line) = 0;
  virtual void stop() = 0;

  // --- Mechanics ---

  /// Moves everything on by `dt` [s]: profiles, current limits, valves, the devices' own watchdogs, alarms.
  virtual void step(double dt) = 0;
  /// Torque [N m] of the load on the shaft of motor `i`, positive towards increasing angle; nothing for a pressure
  /// channel.
  virtual void setLoadTorque(int i, double torque) = 0;
  /// rad, of motor `i`, continuous over turns; 0 for a pressure channel.
  virtual double shaftAngle(int i) const = 0;
  /// Pa gauge in the chamber of channel `i`; 0 for a motor.
  virtual double pressure(int i) const = 0;
  /// Whether actuator `i` may exert effort of its own: torque on and not stopped by its own watchdog, or a valve that
  /// regulates.
  virtual bool energised(int i) const = 0;

  // --- Faults on request; those that a device cannot have do nothing ---

  virtual void setLineFaults(const LineFaults& faults) = 0;
  virtual LineFaultCounts lineFaultCounts() const = 0;
  /// A frozen device neither answers nor moves.
  virtual void setFrozen(int i, bool frozen) = 0;
  virtual void setTemperature(int i, double temperature) = 0;  ///< degC
  virtual void setSupplyVoltage(double voltage) = 0;           ///< V, of every device of the bus
  /// Switches the device of actuator `i` off and on again: what it keeps in volatile memory is lost.
  virtual void powerCycle(int i) = 0;
  /// Leak of the chamber of channel `i`, as the rate [1/s] at which its gauge pressure falls by itself.
  virtual void setLeak(int i, double rate) = 0;
};

}  // namespace sinew
