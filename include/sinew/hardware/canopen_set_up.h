#pragma once

#include <string>
#include <vector>

#include "sinew/hardware/canopen_sdo.h"
#include "sinew/hardware/canopen_settings.h"
#include "sinew/hardware/canopen_units.h"
#include "sinew/hardware/cia402.h"
#include "sinew/hardware/device_bus.h"
#include "sinew/hardware/device_settings.h"

namespace sinew {

/// Leads one CANopen drive from wherever it is to cyclic position mode, switched on where it stands: identity, the
/// user's objects, PDOs, limits, supervision, the state machine, its own homing. One SDO request at a time; nothing
/// moves but in homing. What is to be done is a list of steps, made once; a step is asked for, and answered cycles
/// later.
class CanopenSetUp {
 public:
  /// Objects of the effort that the settings have chosen.
  struct EffortObjects {
    canopen::ObjectAddress limit, actual, rating;
    std::size_t limit_size = 0, actual_size = 0;
  };
  static const EffortObjects& effortObjects(CanopenEffort effort);

  /// Throws ConfigError where the settings cannot be brought into the drive's numbers.
  CanopenSetUp(const CanopenSettings& settings, const WinchDescription& cable, const ActuatorBounds& bounds,
               const DeviceTiming& timing);

  /// Begins anew; `home`: whether the drive is to search for its zero if that is what its cable asks for. It does too
  /// when it turns out to have restarted.
  void start(bool home);
  /// `nmt`: the state that the drive's last heartbeat told. Sets the rating of `units`.
  SetUpProgress update(Time now, CanSender& out, CanopenSdo& sdo, canopen::NmtState nmt, CanopenUnits& units);

  // After kDone:
  std::int32_t position() const { return position_; }          ///< counts, where the drive was found or homed
  std::uint32_t effortLimit() const { return effort_limit_; }  ///< that the drive bounds its effort to
  bool homed() const { return homed_; }
  /// Whether the drive still had what an earlier set-up of this object had told it, and so has not restarted.
  bool wasConfigured() const { return was_configured_; }
  /// After kFailed: what is wrong with the drive.
  const std::string& problem() const { return problem_; }

 private:
  enum class Action {
    kTellNmt,      // sent, and believed
    kReachNmt,     // sent until a heartbeat confirms it
    kCheck,        // the object's value is `value` in the bits of `mask`
    kFindTrace,    // whether the object still has `value`
    kWrite,        // the object gets `value`
    kReadRating,   // of the effort; the steps of the limit get their value by it
    kAwaitMode,    // the drive shows mode `value`
    kSwitchOn,     // by the state machine to operation enabled, with the target where the shaft is
    kHoldPresent,  // the target becomes the position
    kStartHoming,
    kAwaitHoming,
    kReadPosition
  };
  enum class Need { kMust, kMay };  // kMay: a drive without the object is as good
  struct Step {
    Action action;
    canopen::ObjectAddress object;
    std::size_t size;
    std::uint32_t value;
    std::uint32_t mask;
    Need need;
  };
  enum class Outcome { kWait, kAgain, kNext, kFailed };
  enum class Turn { kStatus, kPosition, kTarget, kControl };  // of kSwitchOn and kHoldPresent

  void addWrite(std::uint16_t index, std::uint8_t subindex, std::size_t size, std::uint32_t value,
                Need need = Need::kMust);
  void add(Action action, canopen::ObjectAddress object = {}, std::size_t size = 0, std::uint32_t value = 0,
           std::uint32_t mask = 0xFFFFFFFF);
  void addPdo(std::uint16_t parameters, std::uint32_t id, std::initializer_list<std::uint32_t> mappings);
  void addIdentity(const CanopenSettings& settings);
  void addSupervision(const CanopenSettings& settings, const DeviceTiming& timing);
  void addPdos(const CanopenSettings& settings);
  void addLimits(const CanopenSettings& settings, const ActuatorBounds& bounds, const CanopenUnits& units);
  void addPeriod(double period, const std::string& name);
  void addEffortLimit();
  void addMode(std::uint8_t mode);
  void addHoming(const CanopenSettings& settings, const CanopenUnits& units);

  void ask(const Step& step, CanSender& out, CanopenSdo& sdo);
  void askTurn(CanopenSdo& sdo);
  Outcome answer(const Step& step, canopen::NmtState nmt, const CanopenSdo& sdo, CanopenUnits& units);
  Outcome takeAnswer(const Step& step, const CanopenSdo& sdo, CanopenUnits& units);
  Outcome takeTurn(const Step& step, const CanopenSdo& sdo);
  Outcome takeStatus(const CanopenSdo& sdo);
  Outcome takeHoming(const CanopenSdo& sdo);
  Outcome takeRating(const CanopenSdo& sdo, CanopenUnits& units);
  Outcome again(Duration limit, const std::string& problem);
  Outcome refuse(const Step& step, const CanopenSdo& sdo);
  Outcome fail(const std::string& problem);
  void next();

  std::uint8_t node_;
  EffortObjects effort_;
  double tension_max_;
  bool absolute_encoder_;
  Duration homing_timeout_, answer_time_;
  std::vector<Step> steps_;
  std::size_t limit_ = 0;                          // the step that writes the effort's limit; the next one checks it
  std::size_t homing_begin_ = 0, homing_end_ = 0;  // the steps that only homing needs
  bool home_ = false;

  std::size_t at_ = 0;
  bool asked_ = false;
  Time now_{}, asked_at_{}, began_{};
  bool timed_ = false;  // whether began_ is of this step
  Turn turn_ = Turn::kStatus;
  cia402::State state_ = cia402::State::kNotReady;
  std::uint16_t controlword_ = 0;
  bool at_target_ = false;  // the target is where the shaft was found in this state
  std::int32_t position_ = 0;
  std::uint32_t effort_limit_ = 0;
  bool homed_ = false, was_configured_ = false, set_up_before_ = false;
  std::string problem_;
};

}  // namespace sinew
