#pragma once

#include <algorithm>
#include <vector>

#include "sinew/contact/obstacle_shape.h"

namespace sinew {

/// The nearest points of two features of two surfaces.
struct BruteMinimum {
  Vec3 p, q;
  double distance;
};

namespace brute {

/// The nearest point of a segment or triangle by alternating projections: no formula in common with the code under
/// test.
inline Vec3 nearestOnSegment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const Vec3 ab = b - a;
  return a + std::clamp(ab.dot(x - a) / ab.dot(ab), 0.0, 1.0) * ab;
}

inline Vec3 nearestOnTriangle(const std::array<Vec3, 3>& t, const Vec3& x) {
  Eigen::Matrix<double, 3, 2> base;
  base << t[1] - t[0], t[2] - t[0];
  const Eigen::Vector2d w = (base.transpose() * base).inverse() * (base.transpose() * (x - t[0]));
  if (w.minCoeff() >= 0 && w.sum() <= 1) return t[0] + base * w;
  Vec3 best = nearestOnSegment(t[0], t[1], x);
  for (const Vec3& other : {nearestOnSegment(t[1], t[2], x), nearestOnSegment(t[2], t[0], x)}) {
    if ((other - x).norm() < (best - x).norm()) best = other;
  }
  return best;
}

/// Two segments: the distance is convex in both parameters, so the minimum is inside or on one of four ends.
inline BruteMinimum nearestOfSegments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  BruteMinimum best{a, nearestOnSegment(c, d, a), 0};
  const auto compare = [&](const Vec3& p, const Vec3& q) {
    if ((p - q).norm() < (best.p - best.q).norm()) best = {p, q, 0};
  };
  compare(b, nearestOnSegment(c, d, b));
  compare(nearestOnSegment(a, b, c), c);
  compare(nearestOnSegment(a, b, d), d);
  Eigen::Matrix<double, 3, 2> base;
  base << b - a, c - d;
  const Eigen::Matrix2d normal = base.transpose() * base;
  if (normal.determinant() > 1e-12 * normal(0, 0) * normal(1, 1)) {
    const Eigen::Vector2d w = normal.inverse() * (base.transpose() * (c - a));
    if (w.minCoeff() >= 0 && w.maxCoeff() <= 1) compare(a + w[0] * (b - a), c + w[1] * (d - c));
  }
  best.distance = (best.p - best.q).norm();
  return best;
}

inline BruteMinimum nearestOfTriangles(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  BruteMinimum best{a[0], b[0], 1e300};
  const auto compare = [&](const Vec3& p, const Vec3& q) {
    if ((p - q).norm() < best.distance) best = {p, q, (p - q).norm()};
  };
  for (std::size_t i = 0; i < 3; ++i) {
    compare(a[i], nearestOnTriangle(b, a[i]));
    compare(nearestOnTriangle(a, b[i]), b[i]);
    for (std::size_t j = 0; j < 3; ++j) {
      const BruteMinimum edges = nearestOfSegments(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]);
      compare(edges.p, edges.q);
    }
  }
  return best;
}

/// Whether the segment from a to b passes through the triangle.
inline bool passesThrough(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& t) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double height_a = normal.dot(a - t[0]), height_b = normal.dot(b - t[0]);
  if ((height_a > 0) == (height_b > 0)) return false;
  const Vec3 x = a + height_a / (height_a - height_b) * (b - a);
  return (nearestOnTriangle(t, x) - x).norm() < 1e-12;
}

}  // namespace brute

inline std::array<Vec3, 3> cornersOf(const TriangleMesh& mesh, std::size_t triangle) {
  const CollisionSurface::Triangle& t = mesh.triangles[triangle];
  return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
}

/// Whether an edge of `a` passes through a triangle of `b`.
inline bool pierces(const TriangleMesh& a, const TriangleMesh& b) {
  for (std::size_t ta = 0; ta < a.triangles.size(); ++ta) {
    const std::array<Vec3, 3> x = cornersOf(a, ta);
    for (std::size_t tb = 0; tb < b.triangles.size(); ++tb) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (brute::passesThrough(x[i], x[(i + 1) % 3], cornersOf(b, tb))) return true;
      }
    }
  }
  return false;
}

/// All local minima of the distance of two surfaces that do not touch, from the definition alone: the nearest points of
/// two triangles are a local minimum if no two triangles that hold these points have nearer ones. Each pair of points
/// once.
inline std::vector<BruteMinimum> calcLocalMinima(const TriangleMesh& a, const TriangleMesh& b, double alarm) {
  constexpr double kOn = 1e-10;  // m
  const auto holding = [&](const TriangleMesh& mesh, const Vec3& x) {
    std::vector<std::size_t> list;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if ((brute::nearestOnTriangle(cornersOf(mesh, t), x) - x).norm() < kOn) list.push_back(t);
    }
    return list;
  };
  std::vector<BruteMinimum> nearest(a.triangles.size() * b.triangles.size());
  const auto at = [&](std::size_t ta, std::size_t tb) -> BruteMinimum& {
    return nearest[ta * b.triangles.size() + tb];
  };
  for (std::size_t ta = 0; ta < a.triangles.size(); ++ta) {
    for (std::size_t tb = 0; tb < b.triangles.size(); ++tb) {
      at(ta, tb) = brute::nearestOfTriangles(cornersOf(a, ta), cornersOf(b, tb));
    }
  }
  std::vector<BruteMinimum> minima;
  for (const BruteMinimum& pair : nearest) {
    if (pair.distance > alarm) continue;
    bool is_least = true;
    for (const std::size_t ta : holding(a, pair.p)) {
      for (const std::size_t tb : holding(b, pair.q)) is_least = is_least && at(ta, tb).distance >= pair.distance - kOn;
    }
    const bool is_new = std::none_of(minima.begin(), minima.end(), [&](const BruteMinimum& other) {
      return (other.p - pair.p).norm() < kOn && (other.q - pair.q).norm() < kOn;
    });
    if (is_least && is_new) minima.push_back(pair);
  }
  return minima;
}

}  // namespace sinew
