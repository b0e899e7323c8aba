#pragma once

#include <vector>

#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/can_frame.h"

namespace sinew {

/// One device on a simulated CAN bus, with one actuator or several. Time on the bus (`now`) and time of the mechanics
/// (`step`) pass apart from each other. The bus calls everything, one call at a time.
class SimulatedCanNode {
 public:
  virtual ~SimulatedCanNode() = default;

  virtual int size() const = 0;

  /// A frame of the bus at `now`; what the device sends in answer is appended to `out`.
  virtual void take(const CanFrame& frame, Time now, std::vector<CanFrame>& out) = 0;
  /// What the device sends by itself by `now` (heartbeats, emergencies) is appended to `out`; its time-outs act.
  virtual void update(Time now, std::vector<CanFrame>& out) = 0;

  // As of SimulatedBus, `i` counted within the device.
  virtual void step(double dt) = 0;
  virtual void setLoadTorque(int i, double torque) = 0;
  virtual double shaftAngle(int i) const = 0;
  virtual double pressure(int i) const = 0;
  virtual bool energised(int i) const = 0;
  virtual void setFrozen(bool frozen) = 0;
  virtual void setTemperature(double temperature) = 0;
  virtual void setSupplyVoltage(double voltage) = 0;
  virtual void powerCycle() = 0;
  virtual void setLeak(int i, double rate) = 0;
};

}  // namespace sinew
