#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sinew/hardware/can_frame.h"
#include "sinew/hardware/simulated_chamber.h"

namespace sinew {

/// A pressure board: the firmware of firmware/, compiled for this machine, on top of simulated chambers, valves, pump
/// and tank. Its clock is the sum of the steps.
class SimulatedPressureBoard {
 public:
  struct Parameters {
    int channels = 4;               ///< 1 to 8
    double range_min = -60000;      ///< Pa gauge
    double range_max = 200000;      ///< Pa gauge
    double vacuum = -70000;         ///< Pa gauge of the vacuum source
    double tank_volume = 2e-3;      ///< m3
    double tank_pressure = 250000;  ///< Pa gauge at the start; the pump keeps 0.9 to 1.05 of it
    double pump_flow = 100;         ///< Pa m3/s
    double pump_pressure = 300000;  ///< Pa gauge beyond which the pump gives no more
    double nominal_voltage = 12;    ///< V
    double brown_out = 7;           ///< V below which the electronics stop and the valves fall open to the atmosphere
    SimulatedChamber::Parameters chamber;
  };

  explicit SimulatedPressureBoard(int address) : SimulatedPressureBoard(address, Parameters()) {}
  SimulatedPressureBoard(int address, const Parameters& parameters);
  ~SimulatedPressureBoard();
  SimulatedPressureBoard(SimulatedPressureBoard&&) noexcept;
  SimulatedPressureBoard& operator=(SimulatedPressureBoard&&) noexcept;

  int address() const;
  int size() const;

  /// Bytes of a serial line; answers are appended to `out`, one element a frame.
  void take(const std::uint8_t* data, std::size_t size, std::vector<std::vector<std::uint8_t>>& out);
  /// A frame of a CAN bus; answers are appended to `out`.
  void take(const CanFrame& frame, std::vector<CanFrame>& out);

  void step(double dt);
  double pressure(int channel) const;  ///< Pa gauge, in the chamber
  bool energised(int channel) const;   ///< regulates or seals
  SimulatedChamber& chamber(int channel);

  void setFrozen(bool frozen);
  void setTemperature(double temperature);  ///< degC
  void setSupplyVoltage(double voltage);    ///< V
  void powerCycle();
  void setLeak(int channel, double rate);  ///< 1/s
  void setEmergencyStop(bool pressed);
  void setSensorBroken(int channel, bool broken);
  void setPumpBroken(bool broken);

 private:
  struct Electronics;
  std::unique_ptr<Electronics> electronics_;
};

}  // namespace sinew
