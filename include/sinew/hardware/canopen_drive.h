#pragma once

#include <string>
#include <vector>

#include "sinew/hardware/can_device.h"
#include "sinew/hardware/canopen_sdo.h"
#include "sinew/hardware/canopen_set_up.h"
#include "sinew/hardware/canopen_settings.h"
#include "sinew/hardware/canopen_units.h"
#include "sinew/hardware/cia402.h"
#include "sinew/hardware/device_settings.h"

namespace sinew {

/// One cable on the spool of a CANopen drive (CiA 301, CiA 402), in cyclic synchronous position mode. Its set points
/// take effect with the SYNC of the bus, which the drive answers with its state, position and effort. The drive itself
/// bounds the effort, and stops when the driver's heartbeat is missing.
///
/// A drive that has left operation, for whatever reason, is told to stop until the next set-up.
class CanopenDrive : public CanDevice {
 public:
  /// Throws ConfigError where the settings do not fit the drive's numbers or each other.
  CanopenDrive(const CanopenSettings& settings, const WinchDescription& cable, const ActuatorBounds& bounds,
               const DeviceTiming& timing);

  int size() const override { return 1; }
  bool wantsSync() const override { return true; }
  void startSetUp(bool home_all) override;
  SetUpProgress updateSetUp(Time now, CanSender& out) override;
  void writeSetPoints(const double* set_points, Time now, CanSender& out) override;
  /// Nothing: the bus's SYNC asks. From the set point until the cycle ends, answers count as this cycle's.
  void request(Time, CanSender&) override {}
  bool take(const CanFrame& frame, Time now) override;
  bool complete() const override { return position_seen_ && effort_seen_; }
  void endCycle(Time now) override;
  /// Lowers the drive's bound of effort from the effort that the cable had at the first call. Sends by itself, waits
  /// for no answer, and keeps the drive's watchdog content.
  void relax(const bool* which, double share, CanSender& out) override;
  void switchOff(const bool* which, CanSender& out) override;
  void setZero(int i, double displacement) override;
  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override;
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return counters_; }

 private:
  enum class Life { kIdle, kSetUp, kRunning };

  ActuatorReading& reading() { return readings_[0]; }
  bool finishSetUp(Time now);
  SetUpProgress failSetUp(const std::string& what, CanSender& out);
  void sendHeartbeat(Time now, CanSender& out);
  void sendControl(std::uint16_t controlword, std::int32_t target, CanSender& out);
  void raise(std::uint32_t fault);
  void loseZero();
  bool takeSdo(const CanFrame& frame);
  void takeHeartbeat(canopen::NmtState state);
  void takeEmergency(const canopen::Emergency& emergency);
  void takePosition(const CanFrame& frame, Time now);
  void takeEffort(const CanFrame& frame);
  void takeStatus(std::uint16_t statusword, Time now);
  void watchLimits(std::uint16_t statusword, Time now);
  bool isAnswer(const CanFrame& frame, std::size_t size);
  void updateErrorCode(Time now, CanSender& out);

  CanopenSettings settings_;
  std::string name_;
  double tension_max_, min_, max_;
  Duration watchdog_, heartbeat_period_;
  int missing_limit_;
  CanopenUnits units_;
  CanopenSdo sdo_;
  CanopenSetUp set_up_;
  CanopenSetUp::EffortObjects effort_;
  std::vector<ActuatorReading> readings_;

  Life life_ = Life::kIdle;
  canopen::NmtState nmt_ = canopen::NmtState::kBootUp;
  cia402::State state_ = cia402::State::kNotReady;
  canopen::Emergency emergency_;
  bool asked_code_ = false;  // whether the drive was asked for the code of its fault
  bool restarted_ = false;   // since the last set-up
  bool stopped_ = false;     // out of operation, or thought so: told to stop until the next set-up
  bool off_ = false;         // let go
  bool relaxing_ = false;
  double relaxed_from_ = 0;  // N, at share 1
  std::int32_t counts_ = 0, target_ = 0;
  bool anchored_ = false;  // whether counts_ and read_at_ are of this set-up
  Time read_at_{}, asked_at_{};
  Time heartbeat_at_{};
  bool heartbeat_sent_ = false;
  Time limited_since_{};
  bool limited_ = false;
  bool asked_ = false, position_seen_ = false, effort_seen_ = false;  // in this cycle
  std::string problem_;
  BusCounters counters_;
};

}  // namespace sinew
