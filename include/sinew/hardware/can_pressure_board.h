#pragma once

#include <string>
#include <vector>

#include "sinew/hardware/can_device.h"
#include "sinew/hardware/pressure_board.h"

namespace sinew {

/// A pressure board on a CAN bus.
class CanPressureBoard : public CanDevice {
 public:
  /// `actuators`: those of the board at `address`. Throws ConfigError, see PressureBoard.
  CanPressureBoard(int address, const DeviceTiming& timing, std::vector<PressureActuator> actuators);

  int size() const override { return board_.size(); }

  void startSetUp(bool home_all) override;
  /// Called again after kDone, it keeps the board on where it is.
  SetUpProgress updateSetUp(Time now, CanSender& out) override;

  void writeSetPoints(const double* set_points, Time now, CanSender& out) override;
  void request(Time now, CanSender& out) override;
  bool take(const CanFrame& frame, Time now) override;
  bool complete() const override { return board_.answered(); }
  void endCycle(Time now) override;

  void relax(const bool* which, double share, CanSender& out) override;
  void switchOff(const bool* which, CanSender& out) override;

  /// Pressures need no zero.
  void setZero(int, double) override {}
  const std::vector<ActuatorReading>& readings() const override { return board_.readings(); }
  std::string faultDetail(int i) const override { return board_.faultDetail(i); }
  const std::string& problem() const override { return board_.problem(); }
  const BusCounters& counters() const override { return counters_; }

 private:
  void send(CanSender& out);
  void sendSetPoints(CanSender& out);
  void sendRead(CanSender& out);

  PressureBoard board_;
  PressureFrameReader reader_;
  Duration answer_time_;
  std::vector<CanFrame> frames_;
  bool waiting_ = false;  // for an answer of set-up
  Time sent_{};           // when that was asked for
  bool set_points_sent_ = false;
  BusCounters counters_;
};

}  // namespace sinew
