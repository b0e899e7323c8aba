#include "sinew/hardware/simulated_pressure_bus.h"

#include <algorithm>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kTurnaround = 200e-6;  // s until a board begins to answer

}  // namespace

SimulatedPressureBus::SimulatedPressureBus(const std::vector<Place>& places, int baud,
                                           const SimulatedPressureBoard::Parameters& parameters)
    : SimulatedSerialBus(baud) {
  for (const Place& p : places) {
    const auto same = [&p](const SimulatedPressureBoard& b) { return b.address() == p.address; };
    auto board = std::find_if(boards_.begin(), boards_.end(), same);
    if (board == boards_.end()) board = boards_.emplace(board, p.address, parameters);
    if (p.channel < 0 || p.channel >= board->size())
      throw ConfigError("channel of simulated pressure board " + std::to_string(p.address), std::to_string(p.channel),
                        "0 to " + std::to_string(board->size() - 1));
    places_.push_back({static_cast<std::size_t>(board - boards_.begin()), p.channel});
  }
}

// --- Mechanics and faults ---

void SimulatedPressureBus::step(double dt) {
  const Lock lock(mutex_);
  for (SimulatedPressureBoard& b : boards_) b.step(dt);
}

double SimulatedPressureBus::pressure(int i) const {
  const Lock lock(mutex_);
  return boards_[placeOf(i).board].pressure(placeOf(i).channel);
}

bool SimulatedPressureBus::energised(int i) const {
  const Lock lock(mutex_);
  return boards_[placeOf(i).board].energised(placeOf(i).channel);
}

void SimulatedPressureBus::setFrozen(int i, bool frozen) {
  const Lock lock(mutex_);
  boardOf(i).setFrozen(frozen);
}

void SimulatedPressureBus::setTemperature(int i, double temperature) {
  const Lock lock(mutex_);
  boardOf(i).setTemperature(temperature);
}

void SimulatedPressureBus::setSupplyVoltage(double voltage) {
  const Lock lock(mutex_);
  for (SimulatedPressureBoard& b : boards_) b.setSupplyVoltage(voltage);
}

void SimulatedPressureBus::powerCycle(int i) {
  const Lock lock(mutex_);
  boardOf(i).powerCycle();
}

void SimulatedPressureBus::setLeak(int i, double rate) {
  const Lock lock(mutex_);
  boardOf(i).setLeak(placeOf(i).channel, rate);
}

void SimulatedPressureBus::setEmergencyStop(bool pressed) {
  const Lock lock(mutex_);
  for (SimulatedPressureBoard& b : boards_) b.setEmergencyStop(pressed);
}

void SimulatedPressureBus::setSensorBroken(int i, bool broken) {
  const Lock lock(mutex_);
  boardOf(i).setSensorBroken(placeOf(i).channel, broken);
}

void SimulatedPressureBus::setPumpBroken(int i, bool broken) {
  const Lock lock(mutex_);
  boardOf(i).setPumpBroken(broken);
}

// --- The line ---

void SimulatedPressureBus::take(const std::uint8_t* data, std::size_t size, Time now) {
  const Time heard = answers_.occupy(size, now);
  for (SimulatedPressureBoard& b : boards_) {
    frames_.clear();
    b.take(data, size, frames_);
    for (AnswerQueue::Bytes& frame : frames_) answers_.send(std::move(frame), heard + duration(kTurnaround));
  }
}

}  // namespace sinew
