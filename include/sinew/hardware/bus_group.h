#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sinew/hardware/device_bus.h"

namespace sinew {

/// All buses of a robot as one, its actuators in the order of the robot's description. A bus whose line is gone takes
/// nothing away from the others: they are still written to, read, relaxed and switched off.
class BusGroup : public DeviceBus {
 public:
  struct Member {
    std::unique_ptr<DeviceBus> bus;
    std::string name;
    std::vector<int> actuators;  ///< the group's number of each actuator of the bus
  };
  explicit BusGroup(std::vector<Member> members);

  int size() const override { return static_cast<int>(readings_.size()); }
  /// Opens every bus that is not open yet; false when one could not be.
  bool open(std::string& why) override;
  void close() override;
  /// Whether any is.
  bool isOpen() const override;
  void startSetUp(bool home_all) override;
  SetUpProgress updateSetUp(Time now) override;
  // False when any line is gone.
  bool writeSetPoints(const double* set_points, Time now) override;
  bool read(Time now) override;
  bool relax(const std::vector<bool>& which, double share) override;
  bool switchOff(const std::vector<bool>& which) override;
  void setZero(int i, double displacement) override;
  double zeroCounts(int i) const override;
  void restoreZero(int i, double counts) override;
  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override;
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return counters_; }

 private:
  struct Bus : Member {
    SetUpProgress progress = SetUpProgress::kBusy;
    std::vector<double> set_points;
    std::vector<bool> which;
  };
  void collect(const Bus& bus);
  void collectCounters();
  void serve(Bus& bus, Time now);
  void lose(Bus& bus);
  void choose(Bus& bus, const std::vector<bool>& which);
  std::pair<const Bus*, int> find(int i) const;

  std::vector<Bus> buses_;
  std::vector<ActuatorReading> readings_;
  BusCounters counters_;
  std::string problem_;
};

}  // namespace sinew
