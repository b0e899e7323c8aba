#pragma once

#include <vector>

#include "sinew/hardware/answer_queue.h"
#include "sinew/hardware/simulated_pressure_board.h"
#include "sinew/hardware/simulated_serial_bus.h"

namespace sinew {

/// Simulated pressure boards on one serial line.
class SimulatedPressureBus : public SimulatedSerialBus {
 public:
  /// The board and channel of an actuator.
  struct Place {
    int address = 1;
    int channel = 0;
  };

  /// One board per address that `places` names. Throws ConfigError for an address or channel that no board has.
  explicit SimulatedPressureBus(const std::vector<Place>& places, int baud = 1000000,
                                const SimulatedPressureBoard::Parameters& parameters = {});
  ~SimulatedPressureBus() override { stop(); }

  int size() const override { return static_cast<int>(places_.size()); }

  void step(double dt) override;
  void setLoadTorque(int, double) override {}
  double shaftAngle(int) const override { return 0; }
  double pressure(int i) const override;
  bool energised(int i) const override;

  void setFrozen(int i, bool frozen) override;
  void setTemperature(int i, double temperature) override;
  void setSupplyVoltage(double voltage) override;
  void powerCycle(int i) override;
  void setLeak(int i, double rate) override;
  /// Of every board of the line.
  void setEmergencyStop(bool pressed);
  void setSensorBroken(int i, bool broken);
  void setPumpBroken(int i, bool broken);

 private:
  struct Located {
    std::size_t board = 0;
    int channel = 0;
  };
  void take(const std::uint8_t* data, std::size_t size, Time now) override;
  SimulatedPressureBoard& boardOf(int i) { return boards_[placeOf(i).board]; }
  const Located& placeOf(int i) const { return places_.at(static_cast<std::size_t>(i)); }

  std::vector<SimulatedPressureBoard> boards_;
  std::vector<Located> places_;
  std::vector<AnswerQueue::Bytes> frames_;
};

}  // namespace sinew
