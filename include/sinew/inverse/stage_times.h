#pragma once

#include <chrono>

namespace sinew {

/// Seconds spent in each stage of a cycle, all Newton steps together.
struct StageTimes {
  double assembly = 0, factor = 0, detection = 0, compliance = 0, qp = 0, advance = 0, cycle = 0;
};

/// Adds the time of its scope to one stage.
class StageTimer {
 public:
  explicit StageTimer(double& stage) : stage_(stage), start_(Clock::now()) {}
  ~StageTimer() { stage_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double& stage_;
  Clock::time_point start_;
};

}  // namespace sinew
