#include "applied_estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace sinew {
namespace {

/// A driver of one actuator that keeps a range and a rate, and whose reports arrive `latency` cycles late.
class Driver {
 public:
  Driver(double max, double step, std::size_t latency) : max_(max), step_(step), latency_(latency) {}

  void apply(std::uint32_t sequence, double command) {
    const double wanted = std::min(command, max_);
    applied_ += std::max(-step_, std::min(step_, wanted - applied_));
    reports_.push_back({sequence, applied_});
  }

  void report(AppliedEstimate& estimate) {
    if (reports_.size() <= latency_) return;
    estimate.addReport(reports_.front().sequence, VecX::Constant(1, reports_.front().applied));
    reports_.pop_front();
  }

  double applied() const { return applied_; }

 private:
  struct Report {
    std::uint32_t sequence;
    double applied;
  };
  double max_, step_;
  std::size_t latency_;
  double applied_ = 0;
  std::deque<Report> reports_;
};

/// A controller that goes to `goal` by at most `step` [m] a cycle from where it believes the actuator to be.
double calcCommand(const AppliedEstimate& estimate, double goal, double step) {
  const double from = estimate.applied()[0];
  return from + std::max(-step, std::min(step, goal - from));
}

class AppliedEstimateWithLatency : public ::testing::TestWithParam<std::size_t> {};

TEST_P(AppliedEstimateWithLatency, IsTheNewestCommandOfADriverThatFollows) {
  AppliedEstimate estimate(1);
  estimate.reset(VecX::Zero(1));
  Driver driver(1.0, 1.0, GetParam());
  for (std::uint32_t cycle = 1; cycle <= 200; ++cycle) {
    driver.report(estimate);
    const double command = 0.01 * std::sin(0.1 * cycle);
    estimate.addCommand(cycle, VecX::Constant(1, command));
    driver.apply(cycle, command);
    EXPECT_EQ(estimate.applied()[0], command);
  }
}

TEST_P(AppliedEstimateWithLatency, DoesNotWindUpAtTheDriversRange) {
  AppliedEstimate estimate(1);
  estimate.reset(VecX::Zero(1));
  Driver driver(0.010, 1.0, GetParam());
  std::uint32_t cycle = 0;
  const auto run = [&](double goal) {
    driver.report(estimate);
    const double command = calcCommand(estimate, goal, 0.001);
    estimate.addCommand(++cycle, VecX::Constant(1, command));
    driver.apply(cycle, command);
    return command;
  };
  double largest = 0;
  for (int i = 0; i < 100; ++i) largest = std::max(largest, run(0.05));
  EXPECT_LE(largest, 0.010 + 0.001 * static_cast<double>(GetParam() + 2));
  const double at_the_limit = driver.applied();
  EXPECT_NEAR(at_the_limit, 0.010, 1e-12);
  int cycles_until_it_moves = 0;
  while (driver.applied() > at_the_limit - 1e-6 && cycles_until_it_moves < 50) {
    run(0.0);
    ++cycles_until_it_moves;
  }
  EXPECT_LE(cycles_until_it_moves, 2);
}

TEST_P(AppliedEstimateWithLatency, LetsARateLimitedDriverRunAtItsFullRateWithoutTurningBack) {
  AppliedEstimate estimate(1);
  estimate.reset(VecX::Zero(1));
  const double rate = 0.0005;
  Driver driver(1.0, rate, GetParam());
  double before = 0;
  for (std::uint32_t cycle = 1; cycle <= 300; ++cycle) {
    driver.report(estimate);
    const double command = calcCommand(estimate, 0.05, 0.002);
    estimate.addCommand(cycle, VecX::Constant(1, command));
    driver.apply(cycle, command);
    EXPECT_GE(driver.applied(), before - 1e-12) << "cycle " << cycle;
    before = driver.applied();
  }
  EXPECT_NEAR(driver.applied(), 0.05, 2e-6);
}

INSTANTIATE_TEST_SUITE_P(Cycles, AppliedEstimateWithLatency, ::testing::Values(0u, 1u, 2u, 5u));

TEST(AppliedEstimate, IgnoresReportsOnCommandsThatItDoesNotKnow) {
  AppliedEstimate estimate(2);
  estimate.reset(VecX::Constant(2, 0.5));
  estimate.addReport(7, VecX::Constant(2, 0.9));
  EXPECT_EQ(estimate.applied(), VecX::Constant(2, 0.5));
  estimate.addCommand(1, VecX::Constant(2, 0.6));
  estimate.addReport(2, VecX::Constant(2, 0.9));
  EXPECT_EQ(estimate.applied(), VecX::Constant(2, 0.6));
  for (std::uint32_t sequence = 2; sequence < 200; ++sequence) estimate.addCommand(sequence, VecX::Constant(2, 0.7));
  estimate.addReport(3, VecX::Constant(2, 0.1));
  EXPECT_EQ(estimate.applied(), VecX::Constant(2, 0.7));
}

TEST(AppliedEstimate, TakesTheDifferenceOfEachActuatorByItself) {
  AppliedEstimate estimate(2);
  estimate.reset(VecX::Zero(2));
  estimate.addCommand(1, VecX::Constant(2, 0.01));
  VecX applied(2);
  applied << 0.01, 0.004;
  estimate.addReport(1, applied);
  EXPECT_EQ(estimate.applied()[0], 0.01);
  EXPECT_EQ(estimate.applied()[1], 0.004);
}

}  // namespace
}  // namespace sinew
