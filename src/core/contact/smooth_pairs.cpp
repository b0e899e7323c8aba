#include "sinew/contact/smooth_pairs.h"

#include <algorithm>
#include <cmath>

#include "sinew/contact/convex_minimum.h"

namespace sinew {
namespace {

/// Slope of phi below which a minimum along an edge or in a face counts as level: its dip is below this times half the
/// edge, less than a micrometre.
constexpr double kLevel = 1e-4;
constexpr int kSearchSteps = 40;
constexpr int kRimPoints = 32;  // around each rim of a cylinder

struct FaceMinimum {
  Vec3 weights;
  SurfaceDistance seen;
};

/// The minimum of phi over a triangle: over v in [0, 1] of the minimum over u in [0, 1 - v] of
/// phi(x0 + u (x1 - x0) + v (x2 - x0)). Both are convex; the derivative of the inner minimum by v is that of phi at
/// fixed u, and along the side of the triangle where u has reached its end. That needs a smooth phi, as it is outside
/// of the shape; a triangle that cuts the shape is searched by values.
class FaceMinimiser {
 public:
  FaceMinimiser(const ObstacleShape& shape, const Vec3& x0, const Vec3& x1, const Vec3& x2)
      : shape_(shape), x0_(x0), along_u_(x1 - x0), along_v_(x2 - x0) {}

  FaceMinimum calcMinimum() const {
    const double v = calcConvexMinimum([&](double at) { return calcSlope(at); }, calcSlope(0), calcSlope(1));
    const FaceMinimum minimum = calcAt(v);
    return minimum.seen.distance > 0 ? minimum : calcAt(searchByValue());
  }

 private:
  Vec3 at(double u, double v) const { return x0_ + u * along_u_ + v * along_v_; }
  Vec3 gradient(double u, double v) const { return shape_.calcDistance(at(u, v)).normal; }

  FaceMinimum calcAt(double v) const {
    const double u = calcInner(v);
    return {Vec3(1 - u - v, u, v), shape_.calcDistance(at(u, v))};
  }

  /// Golden section: the v of the least inner minimum.
  double searchByValue() const {
    const double part = (std::sqrt(5.0) - 1) / 2;
    const auto value = [&](double v) { return shape_.calcDistance(at(calcInner(v), v)).distance; };
    double left = 0, right = 1;
    double a = 1 - part, b = part;
    double at_a = value(a), at_b = value(b);
    for (int step = 0; step < kSearchSteps; ++step) {
      if (at_a < at_b) {
        right = b;
        b = a;
        at_b = at_a;
        a = right - part * (right - left);
        at_a = value(a);
      } else {
        left = a;
        a = b;
        at_a = at_b;
        b = left + part * (right - left);
        at_b = value(b);
      }
    }
    return (left + right) / 2;
  }

  double calcInner(double v) const {
    const double end = 1 - v;
    const auto slope = [&](double part) { return gradient(part * end, v).dot(along_u_); };
    return end * calcConvexMinimum(slope, slope(0), slope(1));
  }

  double calcSlope(double v) const {
    const double u = calcInner(v);
    const bool at_end = u >= 1 - v;
    return gradient(u, v).dot(at_end ? Vec3(along_v_ - along_u_) : along_v_);
  }

  const ObstacleShape& shape_;
  Vec3 x0_, along_u_, along_v_;
};

}  // namespace

SmoothPairs::SmoothPairs(const ProximitySettings& settings, const CollisionSurface& topology)
    : settings_(settings), filter_(settings), vertices_(topology.vertices()), edges_(topology.edges().size()) {}

void SmoothPairs::addPairs(const MovingSurface& surface, const ObstacleShape& shape, const Pose& pose, int obstacle,
                           ContactList& list) {
  surface_ = &surface;
  shape_ = &shape;
  list_ = &list;
  rotation_ = pose.linear();
  origin_ = pose.translation();
  obstacle_ = obstacle;
  ++serial_;
  const Box reach = shape.calcBox(pose).grown(filter_.widestAlarm());
  surface.tree().forEachIn(reach, [this](int triangle) { visit(triangle); });
  if (shape.kind() == ObstacleShape::Kind::kCylinder) seeRim();
}

void SmoothPairs::visit(int triangle) {
  const auto& corners = surface_->topology().triangles()[triangle];
  seeVertex(corners[0]);
  if (isOutOfReach(triangle)) return;
  seeVertex(corners[1]);
  seeVertex(corners[2]);
  if (shape_->kind() == ObstacleShape::Kind::kPlane) return;
  for (const int edge : surface_->topology().edgesOf(triangle)) seeEdge(edge);
  seeFace(triangle);
}

bool SmoothPairs::isOutOfReach(int triangle) const {
  const double reach = std::max((surface_->corner(triangle, 1) - surface_->corner(triangle, 0)).norm(),
                                (surface_->corner(triangle, 2) - surface_->corner(triangle, 0)).norm());
  return vertices_[surface_->topology().triangles()[triangle][0]].distance > filter_.widestAlarm() + reach;
}

void SmoothPairs::seeVertex(int vertex) {
  VertexState& state = vertices_[vertex];
  if (state.seen == serial_) return;
  state.seen = serial_;
  state.position = rotation_.transpose() * (surface_->position(vertex) - origin_);
  const SurfaceDistance local = shape_->calcDistance(state.position);
  state.normal = local.normal;
  state.distance = local.distance;
  if (local.distance > filter_.widestAlarm()) return;

  const Vec3 normal = rotation_ * local.normal;
  if (surface_->vertexNormal(vertex).dot(normal) >= 0) return;
  addRow(PairKind::kVertexSmooth, vertex, 0, SurfacePoint::atVertex(*surface_, vertex), local,
         surface_->calcVertexSlope(vertex, normal), surface_->vertexArea(vertex));
}

void SmoothPairs::seeEdge(int edge) {
  EdgeState& state = edges_[edge];
  if (state.seen == serial_) return;
  state.seen = serial_;
  const auto& ends = surface_->topology().edges()[edge].vertices;
  const VertexState& a = vertices_[ends[0]];
  const VertexState& b = vertices_[ends[1]];
  const Vec3 along = b.position - a.position;
  const double level = kLevel * along.norm();
  const double slope_a = a.normal.dot(along), slope_b = b.normal.dot(along);
  state.is_inside = slope_a < -level && slope_b > level;
  if (!state.is_inside) {
    state.t = slope_a >= -level ? 0 : 1;
    state.distance = state.t == 0 ? a.distance : b.distance;
    return;
  }
  const auto slope = [&](double t) { return shape_->calcDistance(a.position + t * along).normal.dot(along); };
  state.t = calcConvexMinimum(slope, slope_a, slope_b);
  const SurfaceDistance local = shape_->calcDistance(a.position + state.t * along);
  state.distance = local.distance;
  state.normal = local.normal;
  const Vec3 normal = rotation_ * local.normal;
  if (local.distance > filter_.widestAlarm() || surface_->edgeNormal(edge).dot(normal) >= 0) return;
  addRow(PairKind::kEdgeSmooth, edge, 0, SurfacePoint::onEdge(*surface_, edge, state.t), local,
         surface_->calcEdgeSlope(edge, normal), surface_->edgeArea(edge));
}

// phi is convex: it has a minimum inside exactly if it falls inwards where it is smallest on the border. That is never
// a corner: there phi rises along both edges, and so in between.
bool SmoothPairs::opensInward(int triangle) const {
  const auto& sides = surface_->topology().edgesOf(triangle);
  int lowest = sides[0];
  for (const int edge : sides) {
    if (edges_[edge].distance < edges_[lowest].distance) lowest = edge;
  }
  if (!edges_[lowest].is_inside) return false;
  const int side = surface_->topology().edges()[lowest].triangles[0] == triangle ? 0 : 1;
  return (rotation_ * edges_[lowest].normal).dot(surface_->calcInward(lowest, side)) < -kLevel;
}

void SmoothPairs::seeFace(int triangle) {
  if (!opensInward(triangle)) return;
  const auto& corners = surface_->topology().triangles()[triangle];
  const FaceMinimiser minimiser(*shape_, vertices_[corners[0]].position, vertices_[corners[1]].position,
                                vertices_[corners[2]].position);
  const FaceMinimum minimum = minimiser.calcMinimum();
  const Vec3 normal = rotation_ * minimum.seen.normal;
  if (minimum.seen.distance > filter_.widestAlarm() || surface_->faceNormal(triangle).dot(normal) >= 0) return;
  addRow(PairKind::kFaceSmooth, triangle, 0, SurfacePoint::onFace(*surface_, triangle, minimum.weights), minimum.seen,
         0, surface_->faceArea(triangle));
}

void SmoothPairs::seeRim() {
  for (int i = 0; i < kRimPoints; ++i) {
    const double angle = 2 * M_PI * i / kRimPoints;
    const Vec3 radial(std::cos(angle), std::sin(angle), 0);
    seeRimPoint(i, radial, shape_->halfSizes().z());
    seeRimPoint(i + kRimPoints, radial, -shape_->halfSizes().z());
  }
}

void SmoothPairs::seeRimPoint(int index, const Vec3& radial, double z) {
  const Vec3 local = shape_->radius() * radial + z * Vec3::UnitZ();
  const Vec3 q = rotation_ * local + origin_;
  const Vec3 axis = rotation_ * (z > 0 ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitZ()));
  const Vec3 outward = rotation_ * radial;
  const Vec3 tangent = axis.cross(outward);
  Box around;
  around.extend(q);
  surface_->tree().forEachIn(around.grown(filter_.widestAlarm()), [&](int triangle) {
    const Vec3 normal = -surface_->faceNormal(triangle);
    const double distance = normal.dot(surface_->corner(triangle, 0) - q);
    const double slope = std::min({normal.dot(axis), normal.dot(outward), -std::abs(normal.dot(tangent))});
    if (distance < -settings_.max_depth || slope < -filter_.widestSlope()) return;
    Vec3 weights;
    if (!surface_->projectsInto(triangle, q, &weights)) return;
    addRow(PairKind::kFaceRim, triangle, index, SurfacePoint::onFace(*surface_, triangle, weights),
           {distance, rotation_.transpose() * normal, local}, slope, surface_->faceArea(triangle));
  });
}

void SmoothPairs::addRow(PairKind kind, int a, int b, const SurfacePoint& point, const SurfaceDistance& local,
                         double slope, double area) {
  const std::uint64_t key = makeContactKey(obstacle_, kind, a, b);
  if (!filter_.accepts(local.distance, slope, key, *list_)) return;
  ContactRow row;
  row.key = key;
  row.obstacle = obstacle_;
  row.point = point.position;
  row.other_point = rotation_ * local.point + origin_;
  row.normal = rotation_ * local.normal;
  row.gap = local.distance - settings_.contact_distance;
  row.area = area;
  ContactEntry entries[3];
  for (int i = 0; i < point.vertices; ++i) {
    entries[i] = {0, surface_->topology().node(point.vertex[i]), point.weight[i] * row.normal};
  }
  list_->add(row, entries, point.vertices);
}

}  // namespace sinew
