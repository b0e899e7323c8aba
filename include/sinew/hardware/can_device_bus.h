#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/can_device.h"
#include "sinew/hardware/can_port.h"
#include "sinew/hardware/device_bus.h"
#include "sinew/hardware/device_settings.h"

namespace sinew {

/// The devices of a robot that share a CAN bus, whatever protocols they speak. Every frame that comes is shown to every
/// device; one that is nobody's counts as stale.
class CanDeviceBus : public DeviceBus {
 public:
  /// Opens the bus; nullptr, with the reason and what would help in its argument, when it cannot.
  using OpenPort = std::function<std::shared_ptr<CanPort>(std::string& why)>;

  /// A device and the numbers that its actuators have on the bus, in the device's order.
  struct Member {
    std::unique_ptr<CanDevice> device;
    std::vector<int> actuators;
  };

  /// Throws ConfigError unless the members' actuators are 0 .. n-1, each once.
  CanDeviceBus(OpenPort open_port, std::vector<Member> members, const DeviceTiming& timing);

  int size() const override { return static_cast<int>(readings_.size()); }
  bool open(std::string& why) override;
  void close() override;
  bool isOpen() const override { return port_ != nullptr; }

  void startSetUp(bool home_all) override;
  SetUpProgress updateSetUp(Time now) override;

  bool writeSetPoints(const double* set_points, Time now) override;
  bool read(Time now) override;
  bool relax(const std::vector<bool>& which, double share) override;
  bool switchOff(const std::vector<bool>& which) override;

  void setZero(int i, double displacement) override;
  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override;
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return counters_; }

  std::uint64_t received() const { return received_; }     ///< frames that have come
  std::uint64_t strangers() const { return strangers_; }   ///< of them, nobody's
  std::uint64_t unsent() const { return sender_.unsent; }  ///< frames for which the bus had no room

 private:
  struct Place {
    std::size_t member = 0;
    int channel = 0;
  };
  // Sends on the bus's port; the time that all frames of a call may wait for room together is over at `deadline`.
  struct Sender : CanSender {
    bool send(const CanFrame& frame) override;
    CanPort* port = nullptr;
    Time deadline{};
    bool closed = false;
    std::uint64_t unsent = 0;
  };
  // A device with room for its part of a call.
  struct Part {
    std::unique_ptr<CanDevice> device;
    std::vector<int> actuators;
    std::vector<double> set_points;
    std::unique_ptr<bool[]> which;
    bool ready = false;
  };

  void startSending();
  bool isLineThere() const;
  void drain(Time now);
  void show(const CanFrame& frame, Time now);
  bool isComplete() const;
  void sendSetPoints(Part& part, Time now);
  void sendSync();
  bool select(Part& part, const std::vector<bool>& which);
  void collect();

  OpenPort open_port_;
  std::shared_ptr<CanPort> port_;
  std::vector<Part> parts_;
  std::vector<Place> places_;
  Duration reply_timeout_;
  Sender sender_;
  bool line_gone_ = false;
  bool asked_ = false;  // by set points that no read has followed yet
  std::vector<ActuatorReading> readings_;
  std::string problem_;
  BusCounters counters_;
  std::uint64_t received_ = 0, strangers_ = 0;
  std::uint64_t damaged_ = 0;  // on ports that are closed by now
};

}  // namespace sinew
