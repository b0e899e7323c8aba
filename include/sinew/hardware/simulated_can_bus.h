#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "sinew/hardware/can_port.h"
#include "sinew/hardware/simulated_bus.h"
#include "sinew/hardware/simulated_can_node.h"

namespace sinew {

/// A CAN bus with simulated devices and one master. Frames wait for the bus, the lowest identifier goes first, and each
/// occupies the bus for its time at the bit rate. Line faults strike what devices send.
class SimulatedCanBus : public SimulatedBus {
 public:
  /// A device and the numbers that its actuators have on the bus, in the device's order.
  struct Member {
    std::unique_ptr<SimulatedCanNode> node;
    std::vector<int> actuators;
  };

  /// Throws ConfigError unless the members' actuators are 0 .. n-1, each once. `bitrate` in bit/s.
  SimulatedCanBus(std::vector<Member> members, int bitrate);
  ~SimulatedCanBus() override;
  SimulatedCanBus(const SimulatedCanBus&) = delete;
  SimulatedCanBus& operator=(const SimulatedCanBus&) = delete;

  int size() const override { return static_cast<int>(places_.size()); }

  /// Serves a master behind an SLCAN adapter, which is simulated too, on `line`.
  void start(ByteStream& line) override;
  /// Serves a master on `port`, of an interface of the kernel or anything else, which must live until `stop()`.
  void start(CanPort& port);
  void stop() override;
  /// Serves `port` once from the calling thread: waits up to `timeout` for a frame or for one that falls due. kClosed
  /// when the port is gone, kTimeout when nothing happened.
  StreamStatus poll(CanPort& port, Duration timeout);

  // The master's side of the bus, for a master without a port. Times never go back.

  /// The master wants to send `frame` at `now`.
  void receive(const CanFrame& frame, Time now);
  /// The next frame that has reached the master by `now`.
  bool transmit(CanFrame& frame, Time now);
  /// Lets devices send what they send by themselves, and frames cross the bus, up to `now`.
  void update(Time now);
  /// When something next reaches the master as far as is known now; Time::max() when nothing is on its way.
  Time nextDue() const;

  void step(double dt) override;
  void setLoadTorque(int i, double torque) override;
  double shaftAngle(int i) const override;
  double pressure(int i) const override;
  bool energised(int i) const override;

  void setLineFaults(const LineFaults& faults) override;
  LineFaultCounts lineFaultCounts() const override;
  void setFrozen(int i, bool frozen) override;
  void setTemperature(int i, double temperature) override;
  void setSupplyVoltage(double voltage) override;
  void powerCycle(int i) override;
  void setLeak(int i, double rate) override;

 private:
  static constexpr std::size_t kMaster = static_cast<std::size_t>(-1);
  struct Place {
    std::size_t node = 0;
    int channel = 0;
  };
  struct Waiting {
    Time ready;
    std::size_t sender;
    CanFrame frame;
  };
  struct Arrival {
    Time due;
    CanFrame frame;
  };

  SimulatedCanNode& node(int i) const { return *nodes_[places_.at(static_cast<std::size_t>(i)).node]; }
  int channel(int i) const { return places_.at(static_cast<std::size_t>(i)).channel; }
  void serve(CanPort* port);
  void startThread(CanPort* port);
  void advance(Time now);
  std::size_t findNext() const;
  Time calcEnd(std::size_t next) const;
  void deliver(const Waiting& sent, Time at);
  void arrive(const CanFrame& frame, Time at);

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<SimulatedCanNode>> nodes_;
  std::vector<Place> places_;
  int bitrate_;
  std::vector<Waiting> waiting_;  // ascending by the time from which they wanted to be sent
  std::deque<Arrival> arrivals_;  // at the master, ascending by due time
  Time line_free_{};
  Time updated_{};
  std::vector<CanFrame> out_;
  LineFaults faults_;
  LineFaultCounts counts_;
  std::mt19937 random_;
  std::unique_ptr<CanPort> adapter_;
  std::thread thread_;
  std::atomic<bool> running_{false};
};

/// The time [s] that a frame keeps a bus of `bitrate` [bit/s] busy, with the most stuff bits that it can need and the
/// pause behind it (ISO 11898-1: a data frame of n bytes has 44 + 8 n bits, an extended one 64 + 8 n, and 3 of pause).
double calcFrameTime(const CanFrame& frame, int bitrate);

}  // namespace sinew
