#pragma once

#include <string>
#include <vector>

#include "sinew/hardware/actuator_reading.h"
#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/can_frame.h"
#include "sinew/hardware/device_bus.h"

namespace sinew {

/// Where a device puts the frames it wants sent.
class CanSender {
 public:
  virtual ~CanSender() = default;
  /// False when the line is gone or full.
  virtual bool send(const CanFrame& frame) = 0;
};

/// The driver's side of one device on a CAN bus, with one actuator or several. It never waits: frames go out through
/// the sender, those that come in are shown to every device of the bus, and set-up moves on by one request at a time.
/// Devices of different protocols share a bus, each knowing its own identifiers.
class CanDevice {
 public:
  virtual ~CanDevice() = default;

  /// The number of actuators, numbered from 0 within the device.
  virtual int size() const = 0;
  /// Whether the bus is to send SYNC (080) at the end of every cycle's set points.
  virtual bool wantsSync() const { return false; }

  virtual void startSetUp(bool home_all) = 0;
  /// Called every cycle until it is done or has failed: sends what is to be sent next, repeats what was not answered,
  /// gives up after some tries.
  virtual SetUpProgress updateSetUp(Time now, CanSender& out) = 0;

  /// Set points [m or Pa], and whatever else keeps the device's watchdog content.
  virtual void writeSetPoints(const double* set_points, Time now, CanSender& out) = 0;
  /// Asks for this cycle's reading; does nothing where set points or SYNC do.
  virtual void request(Time now, CanSender& out) = 0;
  /// A frame of the bus; whether it was this device's.
  virtual bool take(const CanFrame& frame, Time now) = 0;
  /// Whether all that this cycle asked for has come.
  virtual bool complete() const = 0;
  /// Ends the cycle: marks readings valid or missing.
  virtual void endCycle(Time now) = 0;

  /// See DeviceBus::relax and switchOff; `which` has one flag per actuator of the device.
  virtual void relax(const bool* which, double share, CanSender& out) = 0;
  virtual void switchOff(const bool* which, CanSender& out) = 0;

  virtual void setZero(int i, double displacement) = 0;
  virtual const std::vector<ActuatorReading>& readings() const = 0;
  virtual std::string faultDetail(int i) const = 0;
  /// After a failed set-up.
  virtual const std::string& problem() const = 0;
  virtual const BusCounters& counters() const = 0;
};

}  // namespace sinew
