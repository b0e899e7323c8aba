#include "sinew/hardware/command_limiter.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

double clamp(double x, double low, double high) {
  return std::max(low, std::min(high, x));
}

}  // namespace

CommandLimiter::CommandLimiter(std::vector<Limits> limits, double max_interval)
    : limits_(std::move(limits)), max_interval_(max_interval), applied_(limits_.size(), 0.0) {}

void CommandLimiter::reset(const std::vector<double>& applied) {
  std::copy(applied.begin(), applied.end(), applied_.begin());
}

bool CommandLimiter::update(const std::vector<double>& wanted, double interval) {
  bool limited = false;
  const double time = clamp(interval, 0, max_interval_);
  for (std::size_t i = 0; i < applied_.size(); ++i) {
    const Limits& limits = limits_[i];
    const double target = std::isfinite(wanted[i]) ? clamp(wanted[i], limits.min, limits.max) : applied_[i];
    const double step = limits.rate * time;
    const double next = applied_[i] + clamp(target - applied_[i], -step, step);
    applied_[i] = std::abs(target - applied_[i]) <= step ? target : next;
    limited = limited || !(applied_[i] == wanted[i]);
  }
  return limited;
}

}  // namespace sinew
