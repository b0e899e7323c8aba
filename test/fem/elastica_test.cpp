#include "body/newton.h"
#include "check_line.h"
#include "fem/bar_model.h"

namespace sinew {
namespace {

constexpr double kHeight = 0.01;  // m, square section
constexpr double kSlenderness = 40;
constexpr double kLength = kSlenderness * kHeight;
constexpr double kYoungModulus = 1e6;                                                             // Pa
constexpr double kBendingStiffness = kYoungModulus * kHeight * kHeight * kHeight * kHeight / 12;  // N m2

struct Tip {
  double deflection;  // of the length, along the load
  double reach;       // of the length, along the undeformed axis
};

// Euler's elastica under a dead load at the tip: theta'' = -alpha cos(theta), theta(0) = 0, theta'(1) = 0, alpha = P
// L^2 / E I. Shooting on theta'(0) by bisection over Runge-Kutta integration.
Tip exactTip(double alpha) {
  Tip tip{};
  const auto endSlope = [&](double slope) {
    constexpr int kSteps = 4000;
    const double h = 1.0 / kSteps;
    double theta = 0, rate = slope;
    tip = {0, 0};
    for (int i = 0; i < kSteps; ++i) {
      const double k1 = -alpha * std::cos(theta);
      const double k2 = -alpha * std::cos(theta + h / 2 * rate);
      const double k3 = -alpha * std::cos(theta + h / 2 * rate + h * h / 4 * k1);
      const double k4 = -alpha * std::cos(theta + h * rate + h * h / 2 * k2);
      const double middle = theta + h / 2 * rate + h * h / 8 * k1;
      const double next = theta + h * rate + h * h / 6 * (k1 + k2 + k3);
      tip.deflection += h / 6 * (std::sin(theta) + 4 * std::sin(middle) + std::sin(next));
      tip.reach += h / 6 * (std::cos(theta) + 4 * std::cos(middle) + std::cos(next));
      rate += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      theta = next;
    }
    return rate;
  };
  double low = 0, high = alpha;  // the clamp's curvature is at most that of the whole load at full lever
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (endSlope(middle) > 0 ? high : low) = middle;
  }
  return tip;
}

// Tips for the loads, reached one after another. Nothing varies over the width when Poisson's ratio is 0, so cells may
// be wide there; along the axis and over the height they are cubes.
std::vector<Tip> modelTips(int cells, const std::vector<double>& loads) {
  const BarModel bar(Vec3(kLength, kHeight, kHeight), static_cast<int>(kSlenderness) * cells, cells / 6, cells,
                     kYoungModulus, 0.0, 0.0);
  FemBody body(bar.fem, Vec3::Zero());
  std::vector<int> end;
  for (int i = 0; i < bar.fem.nodeCount(); ++i) {
    if (bar.fem.rest()[i].x() > kLength - 1e-9) end.push_back(i);
  }
  std::vector<Tip> tips;
  double reached = 0;
  for (double load : loads) {
    constexpr double kLoadStep = 1.0;
    const int steps = static_cast<int>(std::ceil((load - reached) / kLoadStep));
    for (int k = 1; k <= steps; ++k) {
      const double alpha = reached + (load - reached) * k / steps;
      const double force = alpha * kBendingStiffness / (kLength * kLength);
      VecX external = VecX::Zero(bar.fem.size());
      for (int node : end) external[3 * bar.fem.freeIndex(node) + 2] = -force / static_cast<double>(end.size());
      EXPECT_GE(settle(body, external, k < steps ? 1e-2 : 1e-6, 100, 0.05 * kLength), 0) << "load " << alpha;
    }
    reached = load;
    Vec3 mean = Vec3::Zero();
    for (int node : end) mean += (body.positions()[node] - bar.fem.rest()[node]) / static_cast<double>(end.size());
    tips.push_back({-mean.z() / kLength, 1 + mean.x() / kLength});
  }
  return tips;
}

TEST(Elastica, ConvergesToEuler) {
  const std::vector<double> loads{1, 2, 5};
  const std::vector<Tip> coarse = modelTips(6, loads), fine = modelTips(12, loads);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const Tip exact = exactTip(loads[i]);
    const auto error = [](double a, double b, double reference) {
      return 100 * std::abs(b + (b - a) / 3 - reference) / reference;
    };
    const std::string name = "elastica.load_" + std::to_string(static_cast<int>(loads[i]));
    checkFigure(name + ".deflection_error", error(coarse[i].deflection, fine[i].deflection, exact.deflection), "<=", 2,
                "%");
    checkFigure(name + ".reach_error", error(coarse[i].reach, fine[i].reach, exact.reach), "<=", 2, "%");
  }
}

TEST(Elastica, OracleKnowsPublishedValues) {
  // Bisshopp and Drucker, Quart. Appl. Math. 3 (1945): alpha = 1, 2, 5.
  EXPECT_NEAR(exactTip(1).deflection, 0.3017, 2e-3);
  EXPECT_NEAR(exactTip(2).deflection, 0.4935, 2e-3);
  EXPECT_NEAR(exactTip(5).deflection, 0.7138, 2e-3);
}

}  // namespace
}  // namespace sinew
