#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sinew/hardware/device_bus.h"
#include "sinew/hardware/pressure_board.h"

namespace sinew {

/// Pressure boards on one serial line, each at an address of its own, alone or on an RS-485 chain.
///
/// A cycle asks board by board: the next one as soon as the last has answered or its time on the line is over, so that
/// a silent board takes the others nothing but that time. Answers count whenever they come, until all are there or the
/// reply timeout after the last request has passed.
class SerialPressureBus : public DeviceBus {
 public:
  /// Opens the line, or returns nullptr and says why.
  using LineFactory = std::function<std::shared_ptr<ByteStream>(std::string& why)>;

  /// Throws ConfigError, see PressureBoard.
  SerialPressureBus(LineFactory open_line, int baud, const DeviceTiming& timing,
                    const std::vector<PressureActuator>& actuators);

  int size() const override { return static_cast<int>(places_.size()); }
  bool open(std::string& why) override;
  void close() override { line_.reset(); }
  bool isOpen() const override { return line_ != nullptr; }

  void startSetUp(bool home_all) override;
  SetUpProgress updateSetUp(Time now) override;

  bool writeSetPoints(const double* set_points, Time now) override;
  bool read(Time now) override;
  bool relax(const std::vector<bool>& which, double share) override;
  bool switchOff(const std::vector<bool>& which) override;

  /// Pressures need no zero.
  void setZero(int, double) override {}

  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override;
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return counters_; }

 private:
  struct Place {
    std::size_t board = 0, actuator = 0;
  };
  using Flags = std::array<bool, kMaxPressureChannels>;

  const bool* flagsOf(std::size_t board, const std::vector<bool>& which);
  bool flush();
  bool exchange(const std::vector<bool>& asked);
  bool ask(std::size_t board);
  bool receive(std::size_t first, std::size_t last, Time deadline);
  bool isWaiting(std::size_t board) const { return pending_[board] && !boards_[board].answered(); }
  bool anyWaiting(std::size_t first, std::size_t last) const;
  void takeBytes(const std::uint8_t* data, std::size_t size);
  void takeFrame();
  void settle();
  bool sendSetPoints();
  void collect();
  Duration lineTime(std::size_t bytes) const;
  Duration exchangeTime(const PressureBoard& board, PressureType request) const;
  bool checkCycleTime();

  LineFactory open_line_;
  int baud_;
  Duration period_, reply_timeout_;
  std::vector<PressureBoard> boards_;
  std::vector<Place> places_;  // of the bus's actuators
  std::shared_ptr<ByteStream> line_;
  std::vector<bool> pending_;  // boards asked in this exchange
  std::vector<bool> all_;
  bool prepared_ = false;  // set points wait to be sent
  std::vector<std::uint8_t> out_, frame_, packet_;
  bool overflown_ = false;
  PressureAnswer answer_;
  Flags flags_{};
  std::array<double, kMaxPressureChannels> values_{};
  std::uint64_t damaged_ = 0;  // frames of this exchange
  std::vector<ActuatorReading> readings_;
  std::string problem_;
  BusCounters counters_;
};

}  // namespace sinew
