#include "sinew/common/sampled_signal.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace sinew {
namespace {

SampledSignal makeSignal() {
  MatX values(2, 3);
  values << 0, 10, 10,  //
      1, 1, -3;
  return SampledSignal(Vec3(1, 2, 4), values);
}

Eigen::Vector2d valueAt(const SampledSignal& signal, double time) {
  VecX value;
  signal.calcValue(time, value);
  return value;
}

TEST(SampledSignal, PassesThroughItsSamples) {
  const SampledSignal signal = makeSignal();
  EXPECT_EQ(signal.samples(), 3);
  EXPECT_EQ(signal.size(), 2);
  for (int k = 0; k < signal.samples(); ++k) {
    EXPECT_EQ(valueAt(signal, signal.times()[k]), signal.values().col(k));
  }
}

TEST(SampledSignal, IsLinearBetweenSamples) {
  EXPECT_TRUE(valueAt(makeSignal(), 1.25).isApprox(Eigen::Vector2d(2.5, 1)));
  EXPECT_TRUE(valueAt(makeSignal(), 3.5).isApprox(Eigen::Vector2d(10, -2)));
}

TEST(SampledSignal, KeepsItsEndsOutside) {
  EXPECT_EQ(valueAt(makeSignal(), -5), Eigen::Vector2d(0, 1));
  EXPECT_EQ(valueAt(makeSignal(), 9), Eigen::Vector2d(10, -3));
}

TEST(SampledSignal, MayBeOneSample) {
  const SampledSignal signal(VecX::Constant(1, 3), MatX::Constant(1, 1, 7));
  EXPECT_EQ(signal.samples(), 1);
  VecX value;
  for (double time : {-1.0, 3.0, 8.0}) {
    signal.calcValue(time, value);
    EXPECT_EQ(value[0], 7);
  }
}

TEST(SampledSignal, RefusesTimesThatDoNotRiseAndWrongSizes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SampledSignal(VecX(), MatX(1, 0)), std::invalid_argument);
  EXPECT_THROW(SampledSignal(Eigen::Vector2d(0, 0), MatX::Zero(1, 2)), std::invalid_argument);
  EXPECT_THROW(SampledSignal(Eigen::Vector2d(0, nan), MatX::Zero(1, 2)), std::invalid_argument);
  EXPECT_THROW(SampledSignal(Eigen::Vector2d(0, 1), MatX::Zero(1, 3)), std::invalid_argument);
}

}  // namespace
}  // namespace sinew
