#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "sinew/hardware/actuator_reading.h"
#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// What came on a bus and was not used, counted since construction.
struct BusCounters {
  std::uint64_t corrupted = 0;     ///< damaged: wrong checksum, impossible header or length, noise
  std::uint64_t missing = 0;       ///< expected and never seen in their time
  std::uint64_t device_error = 0;  ///< sound, and telling that the device did not do it
  std::uint64_t stale = 0;         ///< sound, but answering nothing that was asked just now
};

enum class SetUpProgress { kBusy, kDone, kFailed };

/// The actuators of a robot that share one line to their devices, whatever the protocol. One thread calls everything.
/// Actuators are numbered 0 .. size()-1 within their bus.
///
/// Life: `open`, `startSetUp`, `updateSetUp` once a cycle until it is done: every device then holds where the readings
/// say that it was found, its own watchdog armed, and nothing has moved. From then on every cycle `writeSetPoints` and
/// `read`. To let go: `relax` every cycle, with a share that falls from 1 to 0, then `switchOff`. A caller that falls
/// silent is stopped for by the devices themselves.
class DeviceBus {
 public:
  virtual ~DeviceBus() = default;

  virtual int size() const = 0;

  /// Opens the line; when it cannot, says why and what would help in `why`.
  virtual bool open(std::string& why) = 0;
  virtual void close() = 0;
  virtual bool isOpen() const = 0;

  /// Begins to look for every device, to configure it and to switch it on at the position where it is. Faults of the
  /// readings are forgotten, zeros that are still sure are kept unless `home_all`.
  virtual void startSetUp(bool home_all) = 0;
  /// A part of set-up that keeps the caller for no longer than some reply times. After kFailed `problem()` tells the
  /// actuator and what is wrong with it.
  virtual SetUpProgress updateSetUp(Time now) = 0;

  // Each returns false when the line is gone.

  /// One value per actuator [m or Pa].
  virtual bool writeSetPoints(const double* set_points, Time now) = 0;
  /// Brings the readings up to date; takes no longer than the bus's reply timeout plus the time on the line.
  virtual bool read(Time now) = 0;
  /// The actuators in `which` may exert no more than `share` (1 to 0) of the effort that they had at share 1.
  virtual bool relax(const std::vector<bool>& which, double share) = 0;
  /// The actuators in `which` let go for good: torque off, or vented with valves at rest.
  virtual bool switchOff(const std::vector<bool>& which) = 0;

  /// Names the position where cable `i` was last read `displacement` [m], and makes its zero valid.
  virtual void setZero(int i, double displacement) = 0;

  /// What the device of cable `i` itself counts at displacement 0, for whoever writes it down; not a number where a
  /// later life of this software could not make use of it.
  virtual double zeroCounts(int /*i*/) const { return std::numeric_limits<double>::quiet_NaN(); }
  /// Gives back, before any set-up, what `zeroCounts` said in an earlier life. The zero is valid again when set-up
  /// finds that the device has not restarted since.
  virtual void restoreZero(int /*i*/, double /*counts*/) {}

  virtual const std::vector<ActuatorReading>& readings() const = 0;
  /// What the devices' own words add to the fault bits of actuator `i`, e.g. "emergency code 0x3210"; empty when
  /// nothing. For reports, not for the cycle.
  virtual std::string faultDetail(int i) const = 0;
  /// After a failed set-up: the actuator, what is wrong, and what would help.
  virtual const std::string& problem() const = 0;
  virtual const BusCounters& counters() const = 0;
};

}  // namespace sinew
