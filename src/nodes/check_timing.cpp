#include "check_timing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/inverse/inverse_controller.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr double kPeriod = 0.01;             // s
constexpr double kCyclesPerTurn = 200;
constexpr double kRadius = 0.02;       // of the robot's size
constexpr double kFree = 0.25;         // of a period
constexpr double kHighestRate = 2000;  // Hz, of the controller's node
constexpr int kSharing = 2;            // cycles a linearisation
constexpr int kWarmUpCycles = 10;      // caches are cold, pages not there yet

double calcSize(const TetMesh& mesh) {
  Vec3 lower = mesh.nodes.front(), upper = lower;
  for (const Vec3& node : mesh.nodes) {
    lower = lower.cwiseMin(node);
    upper = upper.cwiseMax(node);
  }
  return (upper - lower).norm();
}

/// The motion that is timed: a circle of the first effector.
class TimedRun {
 public:
  explicit TimedRun(const std::shared_ptr<const RobotModel>& robot)
      : robot_(robot), controller_(robot), radius_(kRadius * calcSize(robot->mesh())) {
    controller_.makeSpare();
    rests_ = std::isfinite(controller_.resynchronise(VecX::Zero(robot->actuatorCount())));
    input_.targeted.front() = true;
    input_.period = kPeriod;
  }

  bool rests() const { return rests_; }
  const CycleOutput& output() const { return output_; }

  /// As the controller's node does it: the answer, then what the next one starts from.
  CycleStatus cycle() {
    moveTarget();
    input_.overload = OverloadLevel::kNone;
    const CycleStatus status = controller_.step(input_, output_);
    controller_.prepare(output_);
    return status;
  }

  CycleStatus sharedCycle() {
    moveTarget();
    input_.overload = OverloadLevel::kSharedLinearisation;
    return controller_.step(input_, output_);
  }

  void renew() {
    StageTimes times;
    controller_.beginRenewal();
    controller_.renew(times);
    controller_.endRenewal();
  }

 private:
  void moveTarget() {
    const double angle = kTurn * count_++ / kCyclesPerTurn;
    input_.targets.head<3>() =
        robot_->description().effectors.front().point + radius_ * Vec3(std::cos(angle), std::sin(angle), 0);
  }

  std::shared_ptr<const RobotModel> robot_;
  InverseController controller_;
  double radius_;  // m
  CycleInput input_ = controller_.makeInput();
  CycleOutput output_ = controller_.makeOutput();
  bool rests_ = true;
  int count_ = 0;
};

void add(const CycleOutput& output, CycleTiming& timing) {
  const StageTimes& times = output.times;
  const std::array<double, CycleTiming::kStageCount> seconds = {
      {times.assembly, times.factor, times.detection, times.compliance, times.qp, times.advance}};
  for (std::size_t s = 0; s < seconds.size(); ++s) timing.stages[s].add(seconds[s]);
  timing.cycle.add(times.cycle);
  timing.contacts = std::max(timing.contacts, output.contacts.count);
}

double predict(const DurationSample& cycle) {
  return std::min(kHighestRate, (1 - kFree) / cycle.calcQuantile(0.99));
}

}  // namespace

const char* CycleTiming::nameOf(int stage) {
  constexpr std::array<const char*, kStageCount> kNames = {
      {"assembly", "factor", "detection", "compliance", "quadratic programmes", "advance"}};
  return kNames[static_cast<std::size_t>(stage)];
}

double CycleTiming::predictRate() const {
  return predict(cycle);
}

double CycleTiming::predictSharedRate() const {
  return predict(sharedCycle);
}

double CycleTiming::calcLongest(double rate) {
  return (1 - kFree) / rate;
}

double CycleTiming::shareOf(int stage) const {
  return stages[static_cast<std::size_t>(stage)].calcQuantile(0.5) / cycle.calcQuantile(0.5);
}

CycleTiming timeCycles(std::shared_ptr<const RobotModel> robot, int cycles) {
  TimedRun run(robot);
  CycleTiming timing;
  timing.rests = run.rests();
  for (int k = 0; k < kWarmUpCycles; ++k) run.cycle();
  for (int k = 0; k < cycles; ++k) {
    timing.held += run.cycle() == CycleStatus::kHeld;
    add(run.output(), timing);
  }
  run.sharedCycle();
  for (int k = 0; k < cycles; ++k) {
    if (k % kSharing == 0) run.renew();
    timing.held += run.sharedCycle() == CycleStatus::kHeld;
    timing.sharedCycle.add(run.output().times.cycle);
  }
  return timing;
}

}  // namespace sinew
