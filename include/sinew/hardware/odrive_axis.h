#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/hardware/can_device.h"
#include "sinew/hardware/device_settings.h"
#include "sinew/hardware/odrive_settings.h"
#include "sinew/hardware/winch_description.h"

namespace sinew {

/// One axis of an ODrive that reels a cable, in position control. Its current limit bounds the tension,
///   current limit = tension_max * spool radius / torque constant at the spool's shaft,
/// and its velocity limit the speed.
///
/// An encoder's turns are forgotten when the ODrive restarts. A zero survives a pause of the heartbeats only where the
/// axis is found in closed loop, or unmoved more than a turn from where a restarted encoder counts from.
class OdriveAxis : public CanDevice {
 public:
  /// Throws ConfigError when the tension cannot be bounded, or the axis cannot home as it should.
  OdriveAxis(const OdriveSettings& settings, const WinchDescription& cable, const ActuatorBounds& bounds,
             const DeviceTiming& timing);

  int size() const override { return 1; }

  void startSetUp(bool home_all) override;
  SetUpProgress updateSetUp(Time now, CanSender& out) override;

  void writeSetPoints(const double* set_points, Time now, CanSender& out) override;
  void request(Time now, CanSender& out) override;
  bool take(const CanFrame& frame, Time now) override;
  bool complete() const override { return awaited_ == 0; }
  void endCycle(Time now) override;

  /// Lowers the axis' current limit from the current that it had at the first call.
  void relax(const bool* which, double share, CanSender& out) override;
  void switchOff(const bool* which, CanSender& out) override;

  void setZero(int i, double displacement) override;
  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override;
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return counters_; }

 private:
  enum class Step { kFind, kIdle, kProve, kArm, kLocate, kEnable, kDone };
  using Frames = std::uint32_t;  // one bit a command

  ActuatorReading& reading() { return readings_.front(); }
  SetUpProgress fail(const std::string& what);
  SetUpProgress enter(Step step, Time now);
  SetUpProgress find(Time now, CanSender& out);
  SetUpProgress goIdle(Time now, CanSender& out);
  SetUpProgress proveWatchdog(Time now);
  SetUpProgress armWatchdog(Time now, CanSender& out);
  SetUpProgress locate(Time now, CanSender& out);
  SetUpProgress enable(Time now, CanSender& out);
  bool isDue(Time now);
  bool isOver(double time, Time now) const;
  bool armed() const { return state_ == static_cast<std::uint8_t>(OdriveState::kClosedLoop); }
  bool idle() const { return state_ == static_cast<std::uint8_t>(OdriveState::kIdle); }
  void sendLimits(double current, CanSender& out);

  bool isAwaited(OdriveCommand command) const;
  bool takeMessage(OdriveCommand command, const CanFrame& frame, Time now);
  void takePair(OdriveCommand command, const OdrivePair& pair, Time now);
  void takeHeartbeat(const OdriveHeartbeat& heartbeat, Time now);
  void takeError(std::uint32_t error);
  void takePosition(double turns, Time now);
  void configure(CanSender& out);
  void checkZero();

  double toDisplacement(double turns) const;
  double toTurns(double displacement) const;

  OdriveSettings settings_;
  ActuatorBounds bounds_;
  DeviceTiming timing_;
  double tension_per_ampere_;  // N/A, positive while reeling in
  double turns_per_meter_;     // of the motor, with the sign of reeling in
  double current_limit_;       // A
  double velocity_limit_;      // turn/s

  std::vector<ActuatorReading> readings_;
  BusCounters counters_;
  std::string problem_;
  double zero_ = 0;  // turns at displacement 0

  // What the axis has said
  std::uint8_t state_ = 0;         // in its last heartbeat, ...
  std::uint32_t error_ = 0;        // ... which told this
  Time beat_at_{};                 // when that came
  double silence_ = 0;             // s without heartbeats that were due, since its zero was last known to be sure
  std::uint32_t seen_errors_ = 0;  // since set-up began
  double turns_ = 0;
  Time turns_at_{};
  bool anchored_ = false;  // whether turns_ is of this set-up

  // This cycle
  Frames awaited_ = 0;  // asked for, not yet here
  bool fresh_ = false;  // a position has come
  int auxiliary_ = 0;   // what is asked for beside the position

  bool on_ = false;  // its loop is to be closed
  bool relaxing_ = false;
  double relaxed_from_ = 0;  // A, at share 1

  // Set-up
  Step step_ = Step::kFind;
  Time started_{}, sent_{};  // of this step; sent_: the last that may have to be repeated
  bool home_all_ = false;
  double known_turns_ = 0;  // where it was last, before this set-up
  bool heard_ = false;      // a heartbeat has come since set-up began, ...
  bool spoken_ = false;     // ... since the last message was sent
  bool located_ = false, answered_ = false, version_known_ = false;
  OdriveVersion version_;
  OdriveSdo answer_;
  int armed_writes_ = 0;  // settings of the watchdog that have been read back
  bool proven_ = false;   // its watchdog has been seen to act
  float goal_ = 0;        // turns
};

}  // namespace sinew
