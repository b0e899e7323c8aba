#include "random_qpcc.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew {

namespace {

constexpr int kEffectors = 3;
constexpr double kCableGive = 0.05;  // of a cable's own fixings, against the bar's
constexpr double kEnergy = 1e-3;     // weight of the energy term, against the best-driven direction

using Random = std::mt19937;

double drawUniform(double lower, double upper, Random& random) {
  return std::uniform_real_distribution<double>(lower, upper)(random);
}

double drawNormal(Random& random) {
  return std::normal_distribution<double>()(random);
}

/// Contact forces at given efforts by projected Gauss-Seidel.
VecX solveContacts(const MatX& C_c, const VecX& gap) {
  VecX z = VecX::Zero(gap.size());
  for (int pass = 0; pass < 300; ++pass)
    for (int i = 0; i < z.size(); ++i) z(i) = std::max(0.0, z(i) - (gap(i) + C_c.row(i).dot(z)) / C_c(i, i));
  return z;
}

/// Blocks of a compliance over (unknowns, contacts, effectors).
void setCompliance(const MatX& W, QpccProblem& p) {
  const int na = p.size.unknowns;
  const int nc = p.size.contacts;
  p.A_a = W.topLeftCorner(na, na);
  p.A_c = W.block(0, na, na, nc);
  p.C_a = W.block(na, 0, nc, na);
  p.C_c = W.block(na, na, nc, nc);
  p.E_a = W.bottomLeftCorner(kEffectors, na);
  p.E_c = W.block(na + nc, na, kEffectors, nc);
  const double gain = (p.E_a.transpose() * p.E_a).trace() / p.A_a.trace();
  p.Q = kEnergy * gain * p.A_a;
}

/// The target becomes what the efforts x would reach, scaled.
void aimAt(const VecX& x, double scale, QpccProblem& p) {
  const VecX z = solveContacts(p.C_c, p.C_a * x + p.c);
  p.e = -scale * (p.E_a * x + p.E_c * z);
}

void makeRandom(QpccProblem& p, Random& random) {
  const int na = p.size.unknowns;
  const int nc = p.size.contacts;
  const int n = na + nc + kEffectors;
  const double decay = drawUniform(0.3, 1.0, random);
  MatX B(n, n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) B(i, j) = drawNormal(random) * std::pow(j + 1.0, -decay);
  MatX W = B * B.transpose();
  // Units that differ by orders of magnitude: N and Pa among the unknowns, centimetres as lengths.
  constexpr double kLength = 0.05;
  VecX unit = W.diagonal().cwiseSqrt().cwiseInverse();
  for (int j = 0; j < na; ++j) unit(j) *= random() % 3 == 0 ? 1e-5 : 0.05;
  unit.tail(nc + kEffectors) *= kLength;
  W = unit.asDiagonal() * W * unit.asDiagonal();
  setCompliance(W, p);

  const double offset = drawUniform(0, 0.8, random);
  for (int i = 0; i < nc; ++i) p.c(i) = kLength * (offset + 0.6 * drawNormal(random));
  VecX x(na);
  for (int j = 0; j < na; ++j) {
    const double root = std::sqrt(p.A_a(j, j));
    p.soft_lower(j) = random() % 3 == 0 ? -1 / root : 0;
    p.soft_upper(j) = 1 / root;
    p.row_lower(j) = -root * drawUniform(2, 3, random);
    p.row_upper(j) = root * drawUniform(0.6, 2, random);
    x(j) = 1.2 * drawUniform(p.soft_lower(j), p.soft_upper(j), random);
  }
  aimAt(x, drawUniform(0.3, 1.5, random), p);
  for (int r = 0; r < kEffectors; ++r) p.e(r) += 0.3 * kLength * drawNormal(random);
}

/// A bar clamped at s = 0: bending in y and z, stretching, and the dent a contact makes.
struct Bar {
  double length = 0.16, width = 0.02, youngs_modulus = 3e5;

  double area() const { return width * width; }
  double bending() const { return youngs_modulus * std::pow(width, 4) / 12; }
  double stretching() const { return youngs_modulus * area(); }

  /// Deflection at s of a unit lateral force at t.
  double deflection(double s, double t) const {
    const double near = std::min(s, t);
    return near * near * (3 * std::max(s, t) - near) / (6 * bending());
  }
  /// Deflection at s of a unit moment at t, which is the slope at t of a unit force at s.
  double deflectionOfMoment(double s, double t) const { return (s < t ? s * s : 2 * s * t - t * t) / (2 * bending()); }
  double dent(double s, double t) const { return std::exp(-std::abs(s - t) / width) / (youngs_modulus * width); }
};

/// A cable at an offset from the axis, fixed at a station; a contact at a station, its normal across the axis.
struct Cable {
  double station;
  Eigen::Vector2d offset;
};
struct Touch {
  double station;
  Eigen::Vector2d normal;  ///< from the bar to the obstacle
};

MatX calcBarCompliance(const Bar& bar, const std::vector<Cable>& cables, const std::vector<Touch>& touches) {
  const auto na = static_cast<Eigen::Index>(cables.size());
  const auto nc = static_cast<Eigen::Index>(touches.size());
  MatX W = MatX::Zero(na + nc + kEffectors, na + nc + kEffectors);
  const Eigen::Index tip = na + nc;
  for (Eigen::Index i = 0; i < na; ++i) {
    const Cable& a = cables[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < na; ++j) {
      const Cable& b = cables[static_cast<std::size_t>(j)];
      const double shared = std::min(a.station, b.station);
      W(i, j) = shared * (a.offset.dot(b.offset) / bar.bending() + 1 / bar.stretching());
    }
    W(i, i) *= 1 + kCableGive;
    W.block(tip, i, 2, 1) = a.offset * bar.deflectionOfMoment(bar.length, a.station);
    W(tip + 2, i) = -a.station / bar.stretching();
    for (Eigen::Index k = 0; k < nc; ++k) {
      const Touch& touch = touches[static_cast<std::size_t>(k)];
      W(na + k, i) = W(i, na + k) = -touch.normal.dot(a.offset) * bar.deflectionOfMoment(touch.station, a.station);
    }
  }
  for (Eigen::Index i = 0; i < nc; ++i) {
    const Touch& a = touches[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < nc; ++j) {
      const Touch& b = touches[static_cast<std::size_t>(j)];
      const double cosine = a.normal.dot(b.normal);
      W(na + i, na + j) =
          cosine * bar.deflection(a.station, b.station) + 0.5 * (1 + cosine) * bar.dent(a.station, b.station);
    }
    W.block(tip, na + i, 2, 1) = -a.normal * bar.deflection(bar.length, a.station);
  }
  return W;
}

void makeBar(bool lever, QpccProblem& p, Random& random) {
  const int na = p.size.unknowns;
  const int nc = p.size.contacts;
  const Bar bar;
  std::vector<Cable> cables;
  const double turn = drawUniform(0, 6.28, random);
  for (int j = 0; j < na; ++j) {
    const double angle = turn + 6.28 * j / std::max(na, 3) + 0.3 * drawNormal(random);
    const bool whole = !lever && (j < 2 || random() % 5 < 2);
    const double station = whole ? 1 : (lever ? drawUniform(0.2, 0.6, random) : drawUniform(0.5, 1, random));
    cables.push_back({bar.length * station, 0.5 * bar.width * Eigen::Vector2d(std::cos(angle), std::sin(angle))});
  }

  // Walls on up to four sides, each beside a part of the bar.
  struct Wall {
    double from, to, gap, slope;
  };
  std::vector<Wall> walls;
  for (int side = 0; side < 4; ++side) {
    const double from = lever ? drawUniform(0.45, 0.8, random) : drawUniform(0, 0.6, random);
    const double to = std::min(1.0, from + (lever ? 0.2 : drawUniform(0.2, 0.8, random)));
    const double gap = lever ? drawUniform(0.001, 0.005, random) : drawUniform(0.001, 0.009, random);
    walls.push_back({from, to, gap, lever ? 0 : 0.004 * drawNormal(random)});
  }
  std::vector<Touch> touches;
  for (int i = 0; i < nc; ++i) {
    const int side = static_cast<int>(random() % 4);
    const Wall& wall = walls[static_cast<std::size_t>(side)];
    const double s = drawUniform(wall.from, wall.to, random);
    const double angle = 1.5708 * side + 0.15 * drawNormal(random);
    touches.push_back({bar.length * std::max(s, 0.15), {std::cos(angle), std::sin(angle)}});
    p.c(i) = lever ? wall.gap - 0.0005 + 0.0003 * drawNormal(random)
                   : (wall.gap + wall.slope * s) * (0.4 + 0.6 * s) - 0.0005 + 0.0004 * drawNormal(random);
  }
  setCompliance(calcBarCompliance(bar, cables, touches), p);

  VecX x(na);
  for (int j = 0; j < na; ++j) {
    p.soft_lower(j) = 0;
    p.soft_upper(j) = 0.012 * drawUniform(0.5, 1.5, random) / p.A_a(j, j);
    p.row_lower(j) = -0.05;
    p.row_upper(j) = 0.015;
    x(j) = j == 0 || random() % 5 < 3 ? p.soft_upper(j) * drawUniform(0, 1.2, random) : 0;
  }
  aimAt(x, drawUniform(0.5, 1.5, random), p);
  if (lever || random() % 3 == 0) {
    const double angle = drawUniform(0, 6.28, random);
    const double radius = drawUniform(0.005, 0.05, random);
    p.e = Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.001 * drawNormal(random));
  }
}

}  // namespace

const char* nameOf(QpccKind kind) {
  switch (kind) {
    case QpccKind::kRandom:
      return "random";
    case QpccKind::kBar:
      return "bar";
    case QpccKind::kLever:
      return "lever";
  }
  return "";
}

QpccProblem makeQpcc(QpccKind kind, int unknowns, int contacts, Random& random) {
  QpccProblem problem({unknowns, unknowns, kEffectors, contacts});
  if (kind == QpccKind::kRandom)
    makeRandom(problem, random);
  else
    makeBar(kind == QpccKind::kLever, problem, random);
  return problem;
}

void duplicateContact(int from, int to, double gap, QpccProblem& p) {
  p.C_a.row(to) = p.C_a.row(from);
  p.C_c.row(to) = p.C_c.row(from);
  p.C_c.col(to) = p.C_c.col(from);
  p.A_c.col(to) = p.A_c.col(from);
  p.E_c.col(to) = p.E_c.col(from);
  p.c(to) = p.c(from) + gap;
}

void averageContacts(int first, int second, int to, QpccProblem& p) {
  const double old_gap = p.c(to);
  p.C_a.row(to) = 0.5 * (p.C_a.row(first) + p.C_a.row(second));
  p.C_c.row(to) = 0.5 * (p.C_c.row(first) + p.C_c.row(second));
  p.C_c.col(to) = 0.5 * (p.C_c.col(first) + p.C_c.col(second));
  p.A_c.col(to) = 0.5 * (p.A_c.col(first) + p.A_c.col(second));
  p.E_c.col(to) = 0.5 * (p.E_c.col(first) + p.E_c.col(second));
  p.c(to) = 0.5 * (p.c(first) + p.c(second)) + 0.1 * old_gap;
}

void limitRates(const VecX& centre, double share, QpccProblem& p) {
  const VecX range = share * (p.soft_upper - p.soft_lower);
  p.x_lower = centre - range;
  p.x_upper = centre + range;
}

void holdRow(int row, double share, QpccProblem& p) {
  const VecX x = p.soft_lower + share * (p.soft_upper - p.soft_lower);
  p.row_lower(row) = p.row_upper(row) = p.A_a.row(row).dot(x) + p.a(row);
}

}  // namespace sinew
