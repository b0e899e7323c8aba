#pragma once

#include <string>
#include <vector>

#include "sinew/hardware/cable_transmission.h"
#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/hardware_description.h"

namespace sinew {

/// Fault bits of one servo: the low byte is its hardware error register.
enum ServoFaultBit : std::uint32_t {
  kServoSilent = 1u << 8,       ///< no valid reading for missing_limit cycles
  kServoWatchdog = 1u << 9,     ///< its bus watchdog has stopped it
  kServoLimp = 1u << 10,        ///< its torque is off though it was switched on: it restarted or shut down
  kServoJumped = 1u << 11,      ///< its position jumped: the count of turns is lost
  kServoUndervolted = 1u << 12  ///< its supply dipped: the count of turns may be lost
};

/// What is known of one servo, in the units of its cable.
struct ServoReading {
  bool valid = false;       ///< this cycle brought a reading; otherwise the rest is the last one
  double displacement = 0;  ///< m of cable pulled in
  double tension = 0;       ///< N, from the motor current
  double current = 0;       ///< A, positive while reeling in
  double temperature = 0;   ///< degC
  double voltage = 0;       ///< V
  bool zero_valid = false;
  std::uint32_t fault = 0;  ///< ServoFaultBit
  int missing = 0;          ///< cycles in a row without a valid reading
};

/// The servos of a robot on one bus, as cables: prepares them, writes set points, reads, and lets go. Every servo runs
/// in current-based position mode, so that the device itself bounds the tension, with its bus watchdog armed.
///
/// What a cycle reads is gathered by the servo's indirect addresses into one block that also carries the servo's own
/// millisecond clock: an answer whose clock does not fit the time since the last one is late from an earlier request,
/// and is not believed. The map of indirect addresses is lost when the servo restarts, which tells that its zero is
/// lost.
class ServoChain {
 public:
  explicit ServoChain(const HardwareDescription& description);

  int size() const { return static_cast<int>(servos_.size()); }
  /// The line to use from now on; nullptr for none.
  void attach(ByteStream* line) { bus_.attach(line); }

  enum class Progress { kBusy, kDone, kFailed };
  /// Begins to configure every servo, and then to switch each one on at the position where it is. Nothing moves.
  void startSetUp();
  /// One servo's worth of set-up. After kFailed `problem()` says what is wrong.
  Progress updateSetUp(Time now);

  // Each returns false when the line is gone.
  bool writeSetPoints(const std::vector<double>& displacement);  ///< m
  bool writeTensionLimits(const std::vector<double>& tension);   ///< N, within each servo's own limit
  bool release(const std::vector<bool>& which);                  ///< torque off
  bool read(Time now);

  /// Makes `displacement` [m] the name of the position where servo `i` was last read, and its zero valid.
  void setZero(int i, double displacement);

  const std::vector<ServoReading>& readings() const { return readings_; }
  bool zerosValid() const;
  /// Whether every servo is well; if not, `problem()` names the first that is not, and why.
  bool checkHealth();
  const std::string& problem() const { return problem_; }
  const BusCounters& counters() const { return bus_.counters(); }

 private:
  struct Servo {
    CableTransmission cable;
    ActuatorDescription description;
    std::int32_t counts = 0;
    int tick = 0;           // ms, of the last valid reading
    Time read_at{};         // when that was asked for
    bool anchored = false;  // whether tick, counts and read_at are of this set-up
    Time rebooted{};
    bool rebooting = false;
  };
  enum class Phase { kConfigure, kEnable };

  bool fail(std::size_t i, const std::string& what);
  bool write(std::size_t i, ServoRegister r, std::int32_t value);
  bool read(std::size_t i, ServoRegister r, std::int32_t& value);
  Progress configure(std::size_t i, Time now);
  bool configureRegisters(std::size_t i);
  bool mapReading(std::size_t i, bool& mapped);
  bool enable(std::size_t i);
  void take(std::size_t i, const SyncAnswer& answer);
  bool isFresh(const Servo& servo, const std::uint8_t* data) const;

  DynamixelBus bus_;
  double period_;
  std::int32_t watchdog_units_;
  int missing_limit_;
  std::vector<Servo> servos_;
  std::vector<std::uint8_t> ids_;
  std::vector<std::int32_t> values_;
  std::vector<std::uint8_t> some_ids_;
  std::vector<std::int32_t> some_values_;
  std::vector<SyncAnswer> answers_;
  DynamixelBus::Plausible fresh_;
  Time asked_{};  // when the readings under way were asked for
  std::vector<ServoReading> readings_;
  Phase phase_ = Phase::kConfigure;
  std::size_t next_ = 0;
  bool all_fast_ = true;
  std::string problem_;
};

}  // namespace sinew
