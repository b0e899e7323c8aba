#include "sinew/contact/convex_minimum.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

template <typename Slope>
double minimise(const Slope& slope) {
  return calcConvexMinimum(slope, slope(0), slope(1));
}

TEST(ConvexMinimum, OfSmoothFunctionsIsWhereTheSlopeVanishes) {
  EXPECT_NEAR(minimise([](double t) { return t - 0.3; }), 0.3, 1e-12);
  EXPECT_NEAR(minimise([](double t) { return std::pow(t - 0.7, 3); }), 0.7, 1e-3);
  EXPECT_NEAR(minimise([](double t) { return (t - 0.01) / std::hypot(t - 0.01, 1e-6); }), 0.01, 1e-9);
}

TEST(ConvexMinimum, OfAKinkIsThere) {
  EXPECT_NEAR(minimise([](double t) { return t < 0.123 ? -1e-3 : 1.0; }), 0.123, 1e-6);
}

TEST(ConvexMinimum, OfARisingOrFallingFunctionIsAtItsEnd) {
  EXPECT_EQ(minimise([](double t) { return 1 + t; }), 0);
  EXPECT_EQ(minimise([](double t) { return t - 2; }), 1);
}

TEST(ConvexMinimum, NeedsFewSteps) {
  int calls = 0;
  minimise([&](double t) {
    ++calls;
    return (t - 0.4) / std::hypot(t - 0.4, 0.5);
  });
  EXPECT_LT(calls, 15);
}

}  // namespace
}  // namespace sinew
