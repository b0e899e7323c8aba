#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/simulated_bus.h"
#include "sinew/hardware/socket_can.h"

namespace sinew {

/// Devices that stand in for all those of a hardware description, each bus on a line of its own that the driver opens
/// as its port. What they move is stepped from outside. Actuators are numbered as in the description. Members that
/// deal with lines belong to one thread; all others may be called from any.
class SimulatedHardware {
 public:
  /// Lines are not there until `connect`.
  explicit SimulatedHardware(const HardwareDescription& description);
  ~SimulatedHardware();

  int size() const { return static_cast<int>(actuators_.size()); }

  // --- Lines ---

  int buses() const { return static_cast<int>(lines_.size()); }
  const std::string& port(int bus) const { return lines_[static_cast<std::size_t>(bus)].description.port; }
  /// The bus of that name, or that of an actuator of that name; -1 when there is none.
  int findBus(const std::string& name) const;
  int findActuator(const std::string& name) const;
  /// Puts a line to its devices where the description says that the port is: a pseudo-terminal, or the virtual CAN
  /// interface of that name. Throws ConfigError when it cannot.
  void connect(int bus);
  void disconnect(int bus);

  // --- Mechanics ---

  void step(double dt);
  /// N with which the robot pulls at cable `i`; nothing of it arrives while the cable is snapped.
  void setTension(int i, double tension);
  /// m that the spool of cable `i` has reeled in since the beginning.
  double reeledIn(int i) const;
  /// Pa in the chamber of channel `i`.
  double pressure(int i) const;
  bool energised(int i) const;

  // --- Faults ---

  void setLineFaults(const LineFaults& faults);
  LineFaultCounts lineFaultCounts() const;
  void setFrozen(int i, bool frozen);
  void setTemperature(int i, double temperature);  ///< degC
  void setSupplyVoltage(double voltage);           ///< V, of everything
  void powerCycle(int i);
  void setLeak(int i, double rate);  ///< 1/s
  void setSnapped(int i, bool snapped);
  bool snapped(int i) const { return snapped_[static_cast<std::size_t>(i)]; }

 private:
  struct Line {
    BusDescription description;
    std::unique_ptr<SimulatedBus> bus;
    std::unique_ptr<PseudoTerminal> terminal;
    std::unique_ptr<SocketCan> interface;  // in place of the terminal
  };
  struct Actuator {
    std::string name;
    int bus = 0, index = 0;  // index on the bus
    double reel_radius = 0;  // m of cable reeled in per rad; negative when it reels in turning backwards
  };
  static void connectToInterface(Line& line);
  SimulatedBus& busOf(const Actuator& a) const { return *lines_[static_cast<std::size_t>(a.bus)].bus; }
  const Actuator& at(int i) const { return actuators_[static_cast<std::size_t>(i)]; }

  std::vector<Line> lines_;
  std::vector<Actuator> actuators_;
  std::unique_ptr<std::atomic<bool>[]> snapped_;  // one per actuator
};

}  // namespace sinew
