#include "sinew/contact/obstacle_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kFar = 1e6;  // m, stands for the extent of the plane

void requirePositive(const char* name, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw ConfigError(std::string("obstacle: ") + name, std::to_string(value), "a positive length in m");
  }
}

SurfaceDistance fromNormal(const Vec3& p, double distance, const Vec3& normal) {
  return {distance, normal, p - distance * normal};
}

SurfaceDistance calcSphere(double radius, const Vec3& p) {
  const double norm = p.norm();
  return fromNormal(p, norm - radius, norm > 0 ? Vec3(p / norm) : Vec3(Vec3::UnitX()));
}

double signOf(double value) {
  return value < 0 ? -1 : 1;
}

SurfaceDistance calcBoxDistance(const Vec3& half, const Vec3& p) {
  const Vec3 excess = p.cwiseAbs() - half;
  const Vec3 outside = excess.cwiseMax(0);
  const double distance = outside.norm();
  if (distance > 0) {
    const Vec3 signs(signOf(p.x()), signOf(p.y()), signOf(p.z()));
    return fromNormal(p, distance, signs.cwiseProduct(outside) / distance);
  }
  Eigen::Index axis;
  const double depth = excess.maxCoeff(&axis);
  return fromNormal(p, depth, signOf(p[axis]) * Vec3::Unit(axis));
}

SurfaceDistance calcCylinder(double radius, double half_length, const Vec3& p) {
  const double r = p.head<2>().norm();
  const Vec3 radial = r > 0 ? Vec3(p.x() / r, p.y() / r, 0) : Vec3(Vec3::UnitX());
  const Vec3 axial = signOf(p.z()) * Vec3::UnitZ();
  const double side = r - radius;
  const double end = std::abs(p.z()) - half_length;
  if (side > 0 && end > 0) {
    const double distance = std::sqrt(side * side + end * end);
    return fromNormal(p, distance, (side * radial + end * axial) / distance);
  }
  return side >= end ? fromNormal(p, side, radial) : fromNormal(p, end, axial);
}

/// Narrows [enter, leave] to where |p + t d| <= half along one axis.
bool clipSlab(double p, double d, double half, double* enter, double* leave) {
  if (d == 0) return std::abs(p) <= half;
  const double a = (-half - p) / d;
  const double b = (half - p) / d;
  *enter = std::max(*enter, std::min(a, b));
  *leave = std::min(*leave, std::max(a, b));
  return *enter <= *leave;
}

/// Narrows [enter, leave] to where a t^2 + 2 b t + c <= 0, a >= 0.
bool clipQuadratic(double a, double b, double c, double* enter, double* leave) {
  if (a < std::numeric_limits<double>::epsilon()) return c <= 0;
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return false;
  const double root = std::sqrt(discriminant);
  *enter = std::max(*enter, (-b - root) / a);
  *leave = std::min(*leave, (-b + root) / a);
  return *enter <= *leave;
}

TriangleMesh makeBoxMesh(const Vec3& lower, const Vec3& upper) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(i & 1 ? upper.x() : lower.x(), i & 2 ? upper.y() : lower.y(),
                               i & 4 ? upper.z() : lower.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A body of revolution about z through `profile` (r, z) rings, from a pole below to a pole above.
TriangleMesh makeRevolved(const std::vector<std::array<double, 2>>& profile, double below, double above, int sides) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, below);
  for (const auto& ring : profile) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * M_PI * i / sides;
      mesh.vertices.emplace_back(ring[0] * std::cos(angle), ring[0] * std::sin(angle), ring[1]);
    }
  }
  mesh.vertices.emplace_back(0, 0, above);
  const int rings = static_cast<int>(profile.size());
  const int last = 1 + rings * sides;
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    const auto at = [&](int ring, int k) { return 1 + ring * sides + k; };
    mesh.triangles.push_back({0, at(0, j), at(0, i)});
    for (int ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring, j), at(ring + 1, j)});
      mesh.triangles.push_back({at(ring, i), at(ring + 1, j), at(ring + 1, i)});
    }
    mesh.triangles.push_back({last, at(rings - 1, i), at(rings - 1, j)});
  }
  return mesh;
}

TriangleMesh makeSphereMesh(double radius, int divisions) {
  std::vector<std::array<double, 2>> profile;
  const int rings = std::max(2, divisions / 2);
  for (int i = 1; i < rings; ++i) {
    const double angle = M_PI * i / rings;
    profile.push_back({radius * std::sin(angle), -radius * std::cos(angle)});
  }
  return makeRevolved(profile, -radius, radius, divisions);
}

}  // namespace

ObstacleShape ObstacleShape::makePlane() {
  return {Kind::kPlane, Vec3::Zero()};
}

ObstacleShape ObstacleShape::makeSphere(double radius) {
  requirePositive("radius", radius);
  return {Kind::kSphere, Vec3::Constant(radius)};
}

ObstacleShape ObstacleShape::makeBox(const Vec3& half_sizes) {
  for (int i = 0; i < 3; ++i) requirePositive("half size", half_sizes[i]);
  return {Kind::kBox, half_sizes};
}

ObstacleShape ObstacleShape::makeCylinder(double radius, double length) {
  requirePositive("radius", radius);
  requirePositive("length", length);
  return {Kind::kCylinder, Vec3(radius, radius, length / 2)};
}

ObstacleShape ObstacleShape::makeMesh(const TriangleMesh& mesh) {
  ObstacleShape shape(Kind::kMesh, Vec3::Zero());
  shape.mesh_ = std::make_shared<const MeshDistance>(mesh.vertices, mesh.triangles);
  shape.half_ = shape.mesh_->box().upper.cwiseAbs().cwiseMax(shape.mesh_->box().lower.cwiseAbs());
  return shape;
}

SurfaceDistance ObstacleShape::calcDistance(const Vec3& p) const {
  switch (kind_) {
    case Kind::kPlane:
      return {p.z(), Vec3::UnitZ(), Vec3(p.x(), p.y(), 0)};
    case Kind::kSphere:
      return calcSphere(half_.x(), p);
    case Kind::kBox:
      return calcBoxDistance(half_, p);
    case Kind::kCylinder:
      return calcCylinder(half_.x(), half_.z(), p);
    case Kind::kMesh:
      break;
  }
  return mesh_->calcDistance(p);
}

Box ObstacleShape::calcBox(const Pose& pose) const {
  const Mat3 rotation = pose.linear();
  const Vec3 centre = pose.translation();
  if (kind_ == Kind::kPlane) {
    Box box{Vec3::Constant(-kFar), Vec3::Constant(kFar)};
    for (int i = 0; i < 3; ++i) {
      const bool is_normal = std::abs(rotation(i, 2)) == 1;
      if (is_normal && rotation(i, 2) > 0) box.upper[i] = centre[i];
      if (is_normal && rotation(i, 2) < 0) box.lower[i] = centre[i];
    }
    return box;
  }
  Vec3 middle = Vec3::Zero();
  Vec3 half = half_;
  if (kind_ == Kind::kMesh) {
    middle = (mesh_->box().lower + mesh_->box().upper) / 2;
    half = (mesh_->box().upper - mesh_->box().lower) / 2;
  }
  Vec3 reach = rotation.cwiseAbs() * half;
  if (kind_ == Kind::kSphere) reach = half;
  if (kind_ == Kind::kCylinder) {
    for (int i = 0; i < 3; ++i) {
      const double along = rotation(i, 2);
      reach[i] = half.z() * std::abs(along) + half.x() * std::sqrt(std::max(0.0, 1 - along * along));
    }
  }
  const Vec3 at = pose * middle;
  return {at - reach, at + reach};
}

bool ObstacleShape::calcChord(const Vec3& p, const Vec3& d, double margin, double* enter, double* leave) const {
  *enter = -kFar;
  *leave = kFar;
  switch (kind_) {
    case Kind::kPlane: {
      const double height = p.z() - margin;
      if (d.z() == 0) return height <= 0;
      (d.z() > 0 ? *leave : *enter) = -height / d.z();
      return true;
    }
    case Kind::kSphere: {
      const double r = half_.x() + margin;
      return clipQuadratic(d.squaredNorm(), p.dot(d), p.squaredNorm() - r * r, enter, leave);
    }
    case Kind::kBox:
      for (int i = 0; i < 3; ++i) {
        if (!clipSlab(p[i], d[i], half_[i] + margin, enter, leave)) return false;
      }
      return true;
    case Kind::kCylinder: {
      const double r = half_.x() + margin;
      const auto p2 = p.head<2>();
      const auto d2 = d.head<2>();
      return clipSlab(p.z(), d.z(), half_.z() + margin, enter, leave) &&
             clipQuadratic(d2.squaredNorm(), p2.dot(d2), p2.squaredNorm() - r * r, enter, leave);
    }
    case Kind::kMesh:
      break;
  }
  return false;
}

TriangleMesh ObstacleShape::makeTriangles(int divisions, double plane_size) const {
  const int sides = std::max(3, divisions);
  switch (kind_) {
    case Kind::kPlane:
      return makeBoxMesh(Vec3(-plane_size / 2, -plane_size / 2, -plane_size / 100),
                         Vec3(plane_size / 2, plane_size / 2, 0));
    case Kind::kSphere:
      return makeSphereMesh(half_.x(), std::max(4, sides));
    case Kind::kBox:
      return makeBoxMesh(-half_, half_);
    case Kind::kCylinder:
      return makeRevolved({{half_.x(), -half_.z()}, {half_.x(), half_.z()}}, -half_.z(), half_.z(), sides);
    case Kind::kMesh:
      break;
  }
  return {mesh_->vertices(), mesh_->surface().triangles()};
}

}  // namespace sinew
