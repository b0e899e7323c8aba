#pragma once

#include <string>
#include <vector>

#include "sinew/hardware/device_bus.h"
#include "sinew/hardware/pressure_board_settings.h"
#include "sinew/hardware/pressure_message.h"

namespace sinew {

/// The driver's side of one pressure board, whatever line leads to it: what to ask next, and what its answers mean.
///
/// One request is open at a time: `prepare...` makes it, the transport sends `request()` and shows what comes back to
/// `take`. Channels without an actuator stay vented. Allocates nothing after set-up.
class PressureBoard {
 public:
  /// Throws ConfigError when two actuators share a channel, when a range and a limit contradict each other, or when the
  /// watchdog is none that a board can keep.
  PressureBoard(int address, const DeviceTiming& timing, std::vector<PressureActuator> actuators);

  std::uint8_t address() const { return address_; }
  int size() const { return static_cast<int>(actuators_.size()); }
  /// Channels of the board; the most that the protocol knows before it was asked.
  int channels() const { return identity_.channels > 0 ? identity_.channels : kMaxPressureChannels; }

  // --- Set-up ---

  void startSetUp();
  SetUpProgress progress() const { return progress_; }
  /// Whether the board is configured and read, and waits for the other boards before it is switched on.
  bool awaitsEnable() const { return progress_ == SetUpProgress::kBusy && phase_ == Phase::kEnable; }
  /// Makes set-up's next request; false when there is none. Without `enable` the board is not switched on yet.
  bool prepareSetUp(bool enable);
  /// Set-up's request was not answered in its time.
  void missSetUp();

  // --- Cycle ---

  /// Makes the request with these set points [Pa], one per actuator.
  void prepareSetPoints(const double* set_points);
  /// The same with what `relax` and `switchOff` have left of them.
  void prepareSetPoints();
  void prepareRead();
  const PressureRequest& request() const { return request_; }
  /// An answer of this board. Closes the request that it answers; false when that is not the open one.
  bool take(const PressureAnswer& answer);
  bool answered() const { return answered_; }
  /// Ends a cycle: readings are valid when its request was answered by a state.
  void endCycle();

  /// Set points go to `share` of the pressure that was measured at the first call; at 0 the channel vents.
  void relax(const bool* which, double share);
  void switchOff(const bool* which);

  const std::vector<ActuatorReading>& readings() const { return readings_; }
  std::string faultDetail(int i) const;
  const std::string& problem() const { return problem_; }
  /// Requests that the board refused, since construction.
  std::uint64_t refusals() const { return refusals_; }

 private:
  enum class Phase { kHello, kClear, kConfigure, kRead, kEnable };
  struct Channel {
    double set_point = 0;  // Pa gauge
    PressureMode mode = PressureMode::kVent;
    bool relaxing = false;
    double relaxed_from = 0;  // Pa gauge
    std::uint8_t faults = 0;  // latched here too, for their words
  };

  void fail(const std::string& what);
  void failAt(std::size_t i, const std::string& what);
  void open(PressureType type);
  PressureConfiguration makeConfiguration() const;
  bool answers(const PressureAnswer& answer) const;
  void takeSetUp(const PressureAnswer& answer);
  bool checkIdentity();
  bool checkState(const PressureState& state);
  void seedSetPoints(const PressureState& state);
  void takeState(const PressureState& state);
  void takeChannel(std::size_t i, const PressureState& state);
  bool hasRestarted(const PressureState& state) const;
  const PressureChannelState& channelOf(std::size_t i, const PressureState& state) const {
    return state.channels[static_cast<std::size_t>(actuators_[i].settings.channel)];
  }

  std::uint8_t address_;
  DeviceTiming timing_;
  std::vector<PressureActuator> actuators_;
  std::vector<Channel> channels_;  // one per actuator
  std::vector<ActuatorReading> readings_;
  PressureIdentity identity_;
  PressureRequest request_;
  std::uint16_t sequence_ = 0;
  bool answered_ = true;
  bool read_ = false;  // whether a state has come in this cycle

  SetUpProgress progress_ = SetUpProgress::kFailed;
  Phase phase_ = Phase::kHello;
  int tries_ = 0;
  std::string problem_;

  bool enabled_ = false;
  std::uint32_t uptime_ = 0;  // ms, of the last state
  PressureReason refusal_ = PressureReason::kAccepted;
  std::uint64_t refusals_ = 0;
};

}  // namespace sinew
