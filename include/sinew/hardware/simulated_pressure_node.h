#pragma once

#include <vector>

#include "sinew/hardware/simulated_can_node.h"
#include "sinew/hardware/simulated_pressure_board.h"

namespace sinew {

/// A simulated pressure board on a CAN bus; its actuators are those of its channels that `channels` names.
class SimulatedPressureNode : public SimulatedCanNode {
 public:
  /// Throws ConfigError for a channel that the board does not have.
  SimulatedPressureNode(int address, std::vector<int> channels,
                        const SimulatedPressureBoard::Parameters& parameters = {});

  int size() const override { return static_cast<int>(channels_.size()); }
  void take(const CanFrame& frame, Time now, std::vector<CanFrame>& out) override;
  /// It sends nothing by itself, and its time passes in `step`.
  void update(Time, std::vector<CanFrame>&) override {}

  void step(double dt) override { board_.step(dt); }
  void setLoadTorque(int, double) override {}
  double shaftAngle(int) const override { return 0; }
  double pressure(int i) const override { return board_.pressure(channelOf(i)); }
  bool energised(int i) const override { return board_.energised(channelOf(i)); }
  void setFrozen(bool frozen) override { board_.setFrozen(frozen); }
  void setTemperature(double temperature) override { board_.setTemperature(temperature); }
  void setSupplyVoltage(double voltage) override { board_.setSupplyVoltage(voltage); }
  void powerCycle() override { board_.powerCycle(); }
  void setLeak(int i, double rate) override { board_.setLeak(channelOf(i), rate); }
  void setEmergencyStop(bool pressed) { board_.setEmergencyStop(pressed); }
  void setSensorBroken(int i, bool broken) { board_.setSensorBroken(channelOf(i), broken); }

 private:
  int channelOf(int i) const { return channels_.at(static_cast<std::size_t>(i)); }

  SimulatedPressureBoard board_;
  std::vector<int> channels_;
};

}  // namespace sinew
