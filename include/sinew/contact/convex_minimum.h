#pragma once

#include <cmath>

namespace sinew {

/// Where the derivative of a convex function of t passes through 0 in [0, 1]; it may jump. `slope(t)` is the
/// derivative, `at_0` and `at_1` its values at the ends, which bound t if they do not differ in sign. Regula falsi with
/// the weights of the Illinois rule, each third step a bisection, so that no function is slow.
template <typename Slope>
double calcConvexMinimum(const Slope& slope, double at_0, double at_1) {
  constexpr int kMaxSteps = 60;
  constexpr double kWidth = 1e-12;
  if (!(at_0 < 0)) return 0;
  if (!(at_1 > 0)) return 1;
  double left = 0, right = 1, t = 0.5;
  int last_side = 0;
  for (int step = 0; step < kMaxSteps && right - left > kWidth; ++step) {
    t = step % 3 == 2 ? (left + right) / 2 : (left * at_1 - right * at_0) / (at_1 - at_0);
    const double value = slope(t);
    if (std::abs(value) < kWidth) break;
    if (value < 0) {
      left = t;
      at_0 = value;
      if (last_side < 0) at_1 /= 2;
    } else {
      right = t;
      at_1 = value;
      if (last_side > 0) at_0 /= 2;
    }
    last_side = value < 0 ? -1 : 1;
  }
  return t;
}

}  // namespace sinew
