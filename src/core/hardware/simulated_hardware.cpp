#include "sinew/hardware/simulated_hardware.h"

#include "sinew/common/config_error.h"
#include "sinew/hardware/simulated_can_bus.h"
#include "sinew/hardware/simulated_factory.h"

namespace sinew {

SimulatedHardware::SimulatedHardware(const HardwareDescription& description) {
  for (std::size_t b = 0; b < description.buses.size(); ++b)
    lines_.push_back({description.buses[b], makeSimulatedBus(description, static_cast<int>(b)), nullptr, nullptr});
  for (const ActuatorDescription& a : description.actuators)
    actuators_.push_back({a.name, a.bus, 0, a.cable.sign * a.cable.spool_radius});
  snapped_ = std::make_unique<std::atomic<bool>[]>(actuators_.size());
  for (int b = 0; b < buses(); ++b) {
    int index = 0;
    for (const int i : description.actuatorsOn(b)) actuators_[static_cast<std::size_t>(i)].index = index++;
  }
}

SimulatedHardware::~SimulatedHardware() {
  for (int b = 0; b < buses(); ++b) disconnect(b);
}

// --- Lines ---

int SimulatedHardware::findBus(const std::string& name) const {
  for (int b = 0; b < buses(); ++b)
    if (lines_[static_cast<std::size_t>(b)].description.name == name) return b;
  const int actuator = findActuator(name);
  return actuator < 0 ? -1 : at(actuator).bus;
}

int SimulatedHardware::findActuator(const std::string& name) const {
  for (int i = 0; i < size(); ++i)
    if (at(i).name == name) return i;
  return -1;
}

void SimulatedHardware::connect(int bus) {
  Line& line = lines_[static_cast<std::size_t>(bus)];
  if (line.description.isCanInterface()) return connectToInterface(line);
  line.terminal = std::make_unique<PseudoTerminal>(line.description.port);
  line.bus->start(*line.terminal);
}

void SimulatedHardware::connectToInterface(Line& line) {
  line.interface = std::make_unique<SocketCan>();
  if (!line.interface->open(line.description.port))
    throw ConfigError("CAN interface " + line.description.port, line.interface->error(), "a virtual one that is up");
  dynamic_cast<SimulatedCanBus&>(*line.bus).start(*line.interface);
}

void SimulatedHardware::disconnect(int bus) {
  Line& line = lines_[static_cast<std::size_t>(bus)];
  line.bus->stop();
  line.terminal.reset();
  line.interface.reset();
}

// --- Mechanics ---

void SimulatedHardware::step(double dt) {
  for (Line& line : lines_) line.bus->step(dt);
}

// By virtual work, torque * angle = -tension * reeled in.
void SimulatedHardware::setTension(int i, double tension) {
  busOf(at(i)).setLoadTorque(at(i).index, snapped(i) ? 0 : -at(i).reel_radius * tension);
}

double SimulatedHardware::reeledIn(int i) const {
  return at(i).reel_radius * busOf(at(i)).shaftAngle(at(i).index);
}

double SimulatedHardware::pressure(int i) const {
  return busOf(at(i)).pressure(at(i).index);
}

bool SimulatedHardware::energised(int i) const {
  return busOf(at(i)).energised(at(i).index);
}

// --- Faults ---

void SimulatedHardware::setLineFaults(const LineFaults& faults) {
  LineFaults own = faults;
  for (Line& line : lines_) {
    line.bus->setLineFaults(own);
    ++own.seed;
  }
}

LineFaultCounts SimulatedHardware::lineFaultCounts() const {
  LineFaultCounts all;
  for (const Line& line : lines_) {
    const LineFaultCounts own = line.bus->lineFaultCounts();
    all.sent += own.sent;
    all.corrupted += own.corrupted;
    all.dropped += own.dropped;
    all.delayed += own.delayed;
    all.duplicated += own.duplicated;
  }
  return all;
}

void SimulatedHardware::setFrozen(int i, bool frozen) {
  busOf(at(i)).setFrozen(at(i).index, frozen);
}

void SimulatedHardware::setTemperature(int i, double temperature) {
  busOf(at(i)).setTemperature(at(i).index, temperature);
}

void SimulatedHardware::setSupplyVoltage(double voltage) {
  for (Line& line : lines_) line.bus->setSupplyVoltage(voltage);
}

void SimulatedHardware::powerCycle(int i) {
  busOf(at(i)).powerCycle(at(i).index);
}

void SimulatedHardware::setLeak(int i, double rate) {
  busOf(at(i)).setLeak(at(i).index, rate);
}

void SimulatedHardware::setSnapped(int i, bool snapped) {
  snapped_[static_cast<std::size_t>(i)] = snapped;
  if (snapped) setTension(i, 0);
}

}  // namespace sinew
