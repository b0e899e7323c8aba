#include <array>

#include "body/newton.h"
#include "check_line.h"
#include "fem/bar_model.h"

namespace sinew {
namespace {

constexpr double kHeight = 0.02;          // m, square section
constexpr double kLength = 10 * kHeight;  // m
constexpr double kYoungModulus = 1e6;     // Pa
constexpr double kDensity = 1000;         // kg/m3
constexpr double kGravity = 0.05;         // m/s2, so small that the deflection stays linear

double tipDeflection(int cells, double poisson_ratio) {
  const BarModel bar(Vec3(kLength, kHeight, kHeight), 10 * cells, cells, cells, kYoungModulus, poisson_ratio, kDensity);
  FemBody body(bar.fem, Vec3(0, 0, -kGravity));
  EXPECT_GE(settle(body, VecX::Zero(bar.fem.size()), 1e-5, 10), 0);
  double sum = 0;
  int count = 0;
  for (int i = 0; i < bar.fem.nodeCount(); ++i) {
    if (bar.fem.rest()[i].x() > kLength - 1e-9) sum += bar.fem.rest()[i].z() - body.positions()[i].z(), ++count;
  }
  return sum / count;
}

// Timoshenko's beam under its own weight q: q L^4 / (8 E I) + q L^2 / (2 kappa G A), with Cowper's shear coefficient.
double timoshenko(double poisson_ratio) {
  const double area = kHeight * kHeight;
  const double inertia = area * area / 12;
  const double weight = kDensity * kGravity * area;
  const double kappa = 10 * (1 + poisson_ratio) / (12 + 11 * poisson_ratio);
  const double shear_modulus = kYoungModulus / (2 * (1 + poisson_ratio));
  return weight * std::pow(kLength, 4) / (8 * kYoungModulus * inertia) +
         weight * kLength * kLength / (2 * kappa * shear_modulus * area);
}

// The order p that three meshes agree on, w(n) = w - C n^-p. Not taken against Timoshenko's value: a clamp that also
// stops the section from contracting is stiffer than his by about 1 % at a Poisson's ratio of 0.3.
double observedOrder(const std::array<int, 3>& cells, const std::array<double, 3>& deflections) {
  const double measured = (deflections[1] - deflections[0]) / (deflections[2] - deflections[1]);
  const auto ratio = [&](double p) {
    const auto power = [&](std::size_t i) { return std::pow(cells[i], -p); };
    return (power(0) - power(1)) / (power(1) - power(2));
  };
  double low = 0.1, high = 6;  // the ratio rises with p
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (ratio(middle) < measured ? low : high) = middle;
  }
  return low;
}

class Cantilever : public testing::TestWithParam<double> {};

TEST_P(Cantilever, ConvergesToTimoshenko) {
  const double poisson_ratio = GetParam();
  const std::string name = poisson_ratio == 0 ? "cantilever.nu_0_0." : "cantilever.nu_0_3.";
  const double exact = timoshenko(poisson_ratio);
  const double coarse = tipDeflection(6, poisson_ratio) / exact;
  const double middle = tipDeflection(9, poisson_ratio) / exact;
  const double fine = tipDeflection(12, poisson_ratio) / exact;
  const double extrapolated = fine + (fine - coarse) / 3;
  checkFigure(name + "raw_error", 100 * std::abs(fine - 1), "<=", 5, "%");
  checkFigure(name + "richardson_error", 100 * std::abs(extrapolated - 1), "<=", 2, "%");
  checkFigure(name + "order", observedOrder({{6, 9, 12}}, {{coarse, middle, fine}}), ">=", 1.6, "1");
}

INSTANTIATE_TEST_SUITE_P(PoissonRatios, Cantilever, testing::Values(0.0, 0.3));

}  // namespace
}  // namespace sinew
