#pragma once

#include <algorithm>
#include <deque>
#include <iterator>
#include <random>
#include <vector>

#include "sinew/hardware/can_device.h"
#include "sinew/hardware/line_faults.h"
#include "sinew/hardware/simulated_can_node.h"

namespace sinew {

/// A CAN bus on a virtual clock, with devices of the driver on one side and simulated nodes on the other. Frames of the
/// driver arrive at once, those of the nodes a little later, or as the line's faults will have it.
class CanopenBench : public CanSender {
 public:
  static constexpr double kTick = 1e-3;     // s of mechanics between looks at the line
  static constexpr double kLatency = 3e-4;  // s of a node's answer

  explicit CanopenBench(double period = 0.01, double reply_timeout = 0.004)
      : period_(period), reply_timeout_(reply_timeout) {}

  void add(CanDevice& device) { devices_.push_back(&device); }
  void add(SimulatedCanNode& node) { nodes_.push_back(&node); }
  void setLineFaults(const LineFaults& faults) {
    faults_ = faults;
    random_.seed(faults.seed);
  }
  /// The driver's frames reach nobody.
  void setCut(bool cut) { cut_ = cut; }

  bool send(const CanFrame& frame) override {
    sent_.push_back(frame);
    if (cut_) return true;
    std::vector<CanFrame> out;
    for (SimulatedCanNode* node : nodes_) node->take(frame, now_, out);
    queue(out);
    return true;
  }

  /// Lets `dt` [s] pass for the nodes; the driver sleeps.
  void pass(double dt) {
    for (double left = dt; left > 1e-9; left -= kTick) tick(std::min(left, kTick));
  }

  SetUpProgress setUp(CanDevice& device, bool home_all = false, double time_limit = 20) {
    device.startSetUp(home_all);
    for (double t = 0; t < time_limit; t += period_) {
      deliver();
      const SetUpProgress progress = device.updateSetUp(now_, *this);
      if (progress != SetUpProgress::kBusy) return progress;
      pass(period_);
    }
    return SetUpProgress::kBusy;
  }

  /// One cycle of all devices, one set point each.
  void cycle(const std::vector<double>& set_points) {
    deliver();
    bool sync = false;
    for (std::size_t i = 0; i < devices_.size(); ++i) {
      devices_[i]->writeSetPoints(&set_points[i], now_, *this);
      sync = sync || devices_[i]->wantsSync();
    }
    if (sync) send(makeSync());
    read();
  }

  /// The second half of a cycle.
  void read() {
    for (CanDevice* d : devices_) d->request(now_, *this);
    double waited = 0;
    while (waited < reply_timeout_ - 1e-9 && !complete()) {
      tick(kTick / 2);
      waited += kTick / 2;
      deliver();
    }
    for (CanDevice* d : devices_) d->endCycle(now_);
    pass(period_ - waited);
  }

  /// Shows the devices what has come.
  void deliver() {
    while (!inbox_.empty() && inbox_.front().due <= now_) {
      const CanFrame frame = inbox_.front().frame;
      inbox_.pop_front();
      for (CanDevice* d : devices_) d->take(frame, now_);
    }
  }

  Time now() const { return now_; }
  const std::vector<CanFrame>& sent() const { return sent_; }
  void forget() { sent_.clear(); }

  static CanFrame makeSync() {
    CanFrame frame;
    frame.id = 0x080;
    return frame;
  }

 private:
  struct Late {
    Time due;
    CanFrame frame;
  };

  bool complete() const {
    for (const CanDevice* d : devices_)
      if (!d->complete()) return false;
    return true;
  }

  void tick(double dt) {
    now_ += duration(dt);
    std::vector<CanFrame> out;
    for (SimulatedCanNode* node : nodes_) {
      node->step(dt);
      node->update(now_, out);
    }
    queue(out);
    // What nodes send is heard by the others too.
    std::vector<CanFrame> answers;
    for (const CanFrame& frame : out)
      for (SimulatedCanNode* node : nodes_) node->take(frame, now_, answers);
    queue(answers);
  }

  void queue(const std::vector<CanFrame>& frames) {
    for (const CanFrame& frame : frames) {
      const double u = std::uniform_real_distribution<double>(0, 1)(random_);
      const double drop = faults_.corrupt + faults_.drop, delay = drop + faults_.delay;
      if (u < drop) continue;
      insert(frame, u < delay ? faults_.delay_time : kLatency);
      if (u >= delay && u < delay + faults_.duplicate) insert(frame, kLatency);
    }
  }

  void insert(const CanFrame& frame, double late) {
    const Time due = now_ + duration(late);
    auto at = inbox_.end();
    while (at != inbox_.begin() && std::prev(at)->due > due) --at;
    inbox_.insert(at, {due, frame});
  }

  double period_, reply_timeout_;
  Time now_ = Time{} + duration(1000);
  std::vector<CanDevice*> devices_;
  std::vector<SimulatedCanNode*> nodes_;
  std::deque<Late> inbox_;
  std::vector<CanFrame> sent_;
  LineFaults faults_;
  std::mt19937 random_{1};
  bool cut_ = false;
};

}  // namespace sinew
