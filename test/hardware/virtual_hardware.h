#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/device_factory.h"
#include "sinew/hardware/simulated_can_bus.h"
#include "sinew/hardware/simulated_can_port.h"
#include "sinew/hardware/simulated_factory.h"
#include "sinew/hardware/simulated_pressure_bus.h"
#include "sinew/hardware/simulated_servo_bus.h"

namespace sinew {

/// The clock that all lines of a robot share.
struct VirtualClock {
  Time now{std::chrono::seconds(1)};
  void advanceTo(Time t) { now = std::max(now, t); }
};

/// A master's end of a serial line to simulated devices: waiting for bytes moves the clock. Mechanics stand still.
template <typename Bus>
class VirtualSerialLine : public ByteStream {
 public:
  VirtualSerialLine(Bus& bus, VirtualClock& clock, const bool& plugged) : bus_(bus), clock_(clock), plugged_(plugged) {}

  StreamResult read(std::uint8_t* data, std::size_t capacity, Duration timeout) override {
    if (!plugged_) return {StreamStatus::kClosed, 0};
    clock_.advanceTo(std::min(bus_.nextDue(), clock_.now + timeout));
    const std::size_t count = bus_.transmit(data, capacity, clock_.now);
    return {count > 0 ? StreamStatus::kOk : StreamStatus::kTimeout, count};
  }
  StreamResult write(const std::uint8_t* data, std::size_t size, Duration) override {
    if (!plugged_) return {StreamStatus::kClosed, 0};
    bus_.receive(data, size, clock_.now);
    return {StreamStatus::kOk, size};
  }
  Time now() const override { return clock_.now; }

 private:
  Bus& bus_;
  VirtualClock& clock_;
  const bool& plugged_;
};

/// The same for a CAN bus.
class VirtualCanLine : public CanPort {
 public:
  VirtualCanLine(SimulatedCanBus& bus, VirtualClock& clock, const bool& plugged)
      : bus_(bus), clock_(clock), plugged_(plugged) {}

  StreamStatus send(const CanFrame& frame, Duration) override {
    if (!plugged_) return StreamStatus::kClosed;
    bus_.receive(frame, clock_.now);
    return StreamStatus::kOk;
  }
  StreamStatus receive(CanFrame& frame, Duration timeout) override {
    if (!plugged_) return StreamStatus::kClosed;
    const Time deadline = clock_.now + timeout;
    bus_.update(clock_.now);
    while (!bus_.transmit(frame, clock_.now)) {
      if (clock_.now >= deadline) return StreamStatus::kTimeout;
      clock_.advanceTo(std::min(bus_.nextDue(), std::min(deadline, clock_.now + kLook)));
      bus_.update(clock_.now);
    }
    return StreamStatus::kOk;
  }
  Time now() const override { return clock_.now; }

 private:
  static constexpr auto kLook =
      std::chrono::microseconds(200);  // what devices send by themselves falls due unannounced
  SimulatedCanBus& bus_;
  VirtualClock& clock_;
  const bool& plugged_;
};

/// Simulated devices for every bus of a description, and lines to them on one virtual clock.
class VirtualHardware {
 public:
  explicit VirtualHardware(const HardwareDescription& description) : description_(description) {
    for (std::size_t b = 0; b < description.buses.size(); ++b)
      buses_.push_back(makeSimulatedBus(description, static_cast<int>(b)));
    for (std::size_t b = 0; b < buses_.size(); ++b) {
      int index = 0;
      for (const int i : description.actuatorsOn(static_cast<int>(b))) {
        places_.resize(description.actuators.size());
        places_[static_cast<std::size_t>(i)] = {b, index++};
      }
    }
  }

  LineOpener opener() {
    return {[this](const BusDescription& bus, std::string& why) { return openSerial(bus, why); },
            [this](const BusDescription& bus, std::string& why) { return openCan(bus, why); }};
  }

  SimulatedBus& bus(std::size_t b) { return *buses_[b]; }
  std::size_t buses() const { return buses_.size(); }
  SimulatedBus& busOf(int i) { return *buses_[place(i).bus]; }
  int indexOf(int i) const { return place(i).index; }

  /// Lets `time` [s] pass in the devices' mechanics, and what they send by themselves reach the line.
  void step(double time, const std::vector<double>& tension) {
    constexpr double kStep = 1e-3;
    const int steps = std::max(1, static_cast<int>(std::lround(time / kStep)));
    for (int n = 0; n < steps; ++n) {
      for (std::size_t i = 0; i < tension.size(); ++i) setTension(static_cast<int>(i), tension[i]);
      for (auto& bus : buses_) {
        bus->step(time / steps);
        if (auto* can = dynamic_cast<SimulatedCanBus*>(bus.get())) can->update(clock.now);
      }
    }
  }

  void setTension(int i, double tension) {
    const WinchDescription& w = description_.actuators[static_cast<std::size_t>(i)].cable;
    busOf(i).setLoadTorque(indexOf(i), -w.sign * w.spool_radius * tension);
  }
  /// m of cable, or Pa.
  double value(int i) {
    const ActuatorDescription& a = description_.actuators[static_cast<std::size_t>(i)];
    if (a.quantity == Quantity::kPressure) return busOf(i).pressure(indexOf(i));
    return a.cable.sign * a.cable.spool_radius * busOf(i).shaftAngle(indexOf(i));
  }
  bool energised(int i) { return busOf(i).energised(indexOf(i)); }

  VirtualClock clock;
  bool plugged = true;

 private:
  struct Place {
    std::size_t bus = 0;
    int index = 0;
  };
  const Place& place(int i) const { return places_[static_cast<std::size_t>(i)]; }
  std::size_t find(const BusDescription& bus) const {
    std::size_t b = 0;
    while (description_.buses[b].name != bus.name) ++b;
    return b;
  }

  std::shared_ptr<ByteStream> openSerial(const BusDescription& bus, std::string& why) {
    why = "unplugged";
    if (!plugged) return nullptr;
    SimulatedBus& devices = *buses_[find(bus)];
    if (auto* servos = dynamic_cast<SimulatedServoBus*>(&devices))
      return std::make_shared<VirtualSerialLine<SimulatedServoBus>>(*servos, clock, plugged);
    return std::make_shared<VirtualSerialLine<SimulatedPressureBus>>(dynamic_cast<SimulatedPressureBus&>(devices),
                                                                     clock, plugged);
  }
  std::shared_ptr<CanPort> openCan(const BusDescription& bus, std::string& why) {
    why = "unplugged";
    if (!plugged) return nullptr;
    return std::make_shared<VirtualCanLine>(dynamic_cast<SimulatedCanBus&>(*buses_[find(bus)]), clock, plugged);
  }

  HardwareDescription description_;
  std::vector<std::unique_ptr<SimulatedBus>> buses_;
  std::vector<Place> places_;
};

}  // namespace sinew
