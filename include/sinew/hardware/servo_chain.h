#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/cable_transmission.h"
#include "sinew/hardware/device_bus.h"
#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/hardware_description.h"
#include "sinew/hardware/servo_models.h"

namespace sinew {

/// The servos of a robot on one bus, as cables: prepares them, writes set points, reads, and lets go. Every servo runs
/// in current-based position mode, so that the device itself bounds the tension, with its bus watchdog armed.
///
/// What a cycle reads is gathered by the servo's indirect addresses into one block that also carries the servo's own
/// millisecond clock: an answer whose clock does not fit the time since the last one is late from an earlier request,
/// and is not believed. The map of indirect addresses is lost when the servo restarts, which tells that its zero is
/// lost.
///
/// Models of the series may be mixed; those that keep the block elsewhere are read in a transaction of their own.
class ServoChain : public DeviceBus {
 public:
  /// Opens the line to the servos; returns nothing, and says why in `why`, when it cannot.
  using LineFactory = std::function<std::shared_ptr<ByteStream>(std::string& why)>;

  /// The actuators of `description` on its bus number `bus`.
  ServoChain(const HardwareDescription& description, int bus, LineFactory open_line);

  int size() const override { return static_cast<int>(servos_.size()); }
  bool open(std::string& why) override;
  void close() override;
  bool isOpen() const override { return line_ != nullptr; }
  void startSetUp(bool home_all) override;
  SetUpProgress updateSetUp(Time now) override;
  bool writeSetPoints(const double* set_points, Time now) override;
  bool read(Time now) override;
  bool relax(const std::vector<bool>& which, double share) override;
  bool switchOff(const std::vector<bool>& which) override;
  void setZero(int i, double displacement) override;
  double zeroCounts(int i) const override { return servos_[static_cast<std::size_t>(i)].cable.zero(); }
  void restoreZero(int i, double counts) override;
  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override;
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return bus_.counters(); }

 private:
  struct Servo {
    CableTransmission cable;
    ActuatorDescription description;
    const ServoModel* model = nullptr;
    std::int32_t counts = 0;
    int tick = 0;           // ms, of the last valid reading
    Time read_at{};         // when that was asked for
    bool anchored = false;  // whether tick, counts and read_at are of this set-up
    Time rebooted{};
    bool rebooting = false;
    double relaxed_from = 0;  // N
    bool remembered = false;  // its zero is that of an earlier life of this software
  };
  // Servos whose blocks are at the same address, which one transaction reads.
  struct ReadGroup {
    std::uint16_t address = 0;
    std::vector<std::size_t> members;
    std::vector<std::uint8_t> ids;
    std::vector<SyncAnswer> answers;
    DynamixelBus::Plausible fresh;
  };
  enum class Phase { kConfigure, kEnable };

  bool fail(std::size_t i, const std::string& what);
  bool write(std::size_t i, ServoRegister r, std::int32_t value);
  bool read(std::size_t i, ServoRegister r, std::int32_t& value);
  SetUpProgress configure(std::size_t i, Time now);
  bool identify(std::size_t i);
  bool configureRegisters(std::size_t i);
  bool mapReading(std::size_t i, bool& mapped);
  bool enable(std::size_t i);
  void makeReadGroups();
  void take(std::size_t i, const SyncAnswer& answer);
  bool isFresh(const Servo& servo, const std::uint8_t* data) const;

  LineFactory open_line_;
  std::shared_ptr<ByteStream> line_;
  DynamixelBus bus_;
  double period_;
  std::int32_t watchdog_units_;
  int missing_limit_;
  std::vector<Servo> servos_;
  std::vector<std::uint8_t> ids_;
  std::vector<std::int32_t> values_;
  std::vector<std::uint8_t> some_ids_;
  std::vector<std::int32_t> some_values_;
  std::vector<ReadGroup> groups_;
  Time asked_{};  // when the readings under way were asked for
  std::vector<ActuatorReading> readings_;
  Phase phase_ = Phase::kConfigure;
  std::size_t next_ = 0;
  bool all_fast_ = true;
  std::string problem_;
};

}  // namespace sinew
