#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sinew/hardware/simulated_can_node.h"
#include "sinew/hardware/simulated_object_dictionary.h"

namespace sinew {

/// A geared motor with a spool on a CANopen drive, as its bus sees it: object dictionary, SDO server, PDOs that can be
/// mapped, network states, heartbeats in both directions, emergencies, and the state machine of CiA 402 with cyclic
/// synchronous position and homing. It is strict: a PDO is mapped only while it is off and out of the operational
/// state, what does not fit is refused.
///
/// Mechanics are quasi-static, damping * omega = motor torque + load torque - friction of a limp shaft, all at the
/// spool, with the motor torque bounded by objects 6072, 6073 and 3001:02. A target that is not where the shaft stands
/// moves it as soon as operation is enabled.
class SimulatedCia402Drive : public SimulatedCanNode {
 public:
  struct Parameters {
    double counts_per_turn = 4096;           ///< of the motor
    double gear = 10;                        ///< turns of the motor per turn of the spool
    bool absolute_encoder = false;           ///< otherwise it counts from 0 after power-up
    double rated_torque = 0.1;               ///< N m of the motor; object 6076 counts mN m
    double rated_current = 2;                ///< A; object 6075 counts mA
    double peak = 3;                         ///< torque that the motor can reach, in rated ones
    double no_load_speed = 30;               ///< rad/s of the spool at 24 V
    double damping = 0.01;                   ///< N m s/rad
    double friction = 0.02;                  ///< N m that the gear of a limp shaft holds
    double response_time = 0.005;            ///< s with which the shaft follows the demand
    double max_temperature = 100;            ///< degC
    double min_voltage = 18;                 ///< V
    double max_voltage = 56;                 ///< V
    double brown_out = 9;                    ///< V below which the electronics stop
    double lower_switch = -3;                ///< rad of the spool, limit switches that homing looks for
    double upper_switch = 3;                 ///< rad
    std::uint32_t device_type = 0x00020192;  ///< object 1000: servo drive of profile 402
    std::uint32_t vendor = 0x000000FB;       ///< object 1018:01
    std::uint32_t product = 0x63500000;      ///< object 1018:02
  };

  SimulatedCia402Drive(std::uint8_t node, const Parameters& parameters);
  // Its dictionary holds on to it.
  SimulatedCia402Drive(const SimulatedCia402Drive&) = delete;
  SimulatedCia402Drive& operator=(const SimulatedCia402Drive&) = delete;

  int size() const override { return 1; }
  void take(const CanFrame& frame, Time now, std::vector<CanFrame>& out) override;
  void update(Time now, std::vector<CanFrame>& out) override;

  void step(double dt) override;
  void setLoadTorque(int, double torque) override { load_ = torque; }
  double shaftAngle(int) const override { return angle_; }
  double pressure(int) const override { return 0; }
  bool energised(int) const override;
  void setFrozen(bool frozen) override { frozen_ = frozen; }
  void setTemperature(double temperature) override;
  void setSupplyVoltage(double voltage) override;
  void powerCycle() override { boot(); }
  void setLeak(int, double) override {}

  /// For set-up of tests: turns the shaft by hand.
  void setShaftAngle(double angle) { angle_ = demand_ = angle; }
  double motorTorque() const { return torque_; }  ///< N m at the spool
  std::uint16_t statusword() const;
  /// Value of an entry; throws std::logic_error when there is none.
  std::int64_t object(std::uint16_t index, std::uint8_t subindex = 0) const { return dictionary_.get(index, subindex); }
  void setObject(std::uint16_t index, std::uint8_t subindex, std::int64_t value) {
    dictionary_.set(index, subindex, value);
  }

 private:
  enum class State {
    kSwitchOnDisabled,
    kReadyToSwitchOn,
    kSwitchedOn,
    kOperationEnabled,
    kQuickStop,
    kFaultReaction,
    kFault
  };
  enum class Nmt : std::uint8_t { kStopped = 4, kOperational = 5, kPreOperational = 127 };
  enum class Homing { kIdle, kToSwitch, kOffSwitch, kAttained };
  static constexpr std::size_t kPdos = 4;

  struct Received {
    bool pending = false;
    CanFrame frame;
  };

  void addObjects();
  void addNumber(std::uint16_t index, std::uint8_t subindex, std::uint8_t size, bool is_signed, bool writable,
                 SimulatedObjectDictionary::Mapping mapping, std::int64_t initial, std::int64_t min, std::int64_t max);
  void addPdos();
  void boot();

  std::uint32_t check(std::uint16_t index, std::uint8_t subindex, std::int64_t value) const;
  std::uint32_t checkPdo(std::uint16_t index, std::uint8_t subindex, std::int64_t value) const;
  std::uint32_t checkMapping(std::uint16_t index, std::uint8_t subindex, std::int64_t value) const;
  void written(std::uint16_t index, std::uint8_t subindex);

  void takeNmt(std::uint8_t command);
  void takeSync(std::vector<CanFrame>& out);
  void takePdo(const CanFrame& frame);
  void applyPdo(std::size_t n);
  std::uint8_t mappedCount(std::uint16_t mapping) const;
  std::size_t mappedBytes(std::uint16_t mapping) const;
  bool pdoValid(std::uint16_t parameters) const;
  CanFrame makeTpdo(std::size_t n);
  void sendEvents(std::vector<CanFrame>& out);
  void updateConsumer(Time now);
  void updateProducer(Time now, std::vector<CanFrame>& out);

  void control(std::uint16_t word);
  void enterOperation();
  void beginStop(State state);
  void beginQuickStop();
  void stopConnection();
  void raiseFault(std::uint16_t code, std::uint8_t error_register);
  void sendEmergency(std::uint16_t code, std::uint8_t error_register);
  void resetFault();
  void updateAlarms();
  bool torqueOn() const;

  std::int32_t toCounts(double angle) const;
  double toAngle(double counts) const;
  double omegaOf(std::int64_t rpm) const;
  void refresh();
  void retarget();
  void substep(double dt);
  void updateDemand(double dt);
  void updateStop(double dt);
  void updateHoming(double dt);
  void startHoming();
  void finishHoming();
  double torqueLimit() const;
  void watchFollowing(double dt);

  Parameters parameters_;
  std::uint8_t node_;
  SimulatedObjectDictionary dictionary_;
  SimulatedSdoServer server_;

  Nmt nmt_ = Nmt::kPreOperational;
  bool boot_up_due_ = true;
  std::array<Received, kPdos> received_;
  std::array<int, kPdos> syncs_{};            // since each TPDO was sent
  std::array<CanFrame, kPdos> last_event_{};  // TPDOs that are sent when they change
  std::vector<CanFrame> emergencies_;
  Time heartbeat_at_{}, consumed_at_{};
  bool heartbeat_sent_ = false, consumer_armed_ = false;
  Time now_{};

  State state_ = State::kSwitchOnDisabled;
  std::uint16_t controlword_ = 0;
  Homing homing_ = Homing::kIdle;

  double angle_ = 0, omega_ = 0, torque_ = 0, load_ = 0;  // rad, rad/s, N m, N m at the spool
  double demand_ = 0, demand_speed_ = 0;                  // rad, rad/s
  double target_ = 0, time_left_ = 0;                     // rad, s until the demand is there
  double following_time_ = 0;                             // s outside the window
  bool at_limit_ = false;
  double zero_ = 0;  // rad, where the position counts from
  double temperature_ = 30, voltage_ = 24;
  bool powered_ = true, frozen_ = false;
};

}  // namespace sinew
