#include "sinew/contact/surface_pairs.h"

#include <algorithm>
#include <cmath>

#include "sinew/common/config_error.h"
#include "sinew/contact/closest_point.h"

namespace sinew {
namespace {

constexpr double kTie = 1e-6;       // slope, or part of an edge, that counts as level
constexpr double kTouching = 1e-7;  // m below which two points have no direction
constexpr double kFar = 1e300;
constexpr double kMaterialReach =
    4;  // times max_depth: what was behind at rest and as near is the other side of a wall

}  // namespace

void RegionPairs::add(const std::vector<int>& triangles, const std::vector<int>& other_triangles, int triangle_count) {
  const auto mark = [&](const std::vector<int>& list) {
    std::vector<char> marks(triangle_count, 0);
    for (const int triangle : list) {
      if (triangle < 0 || triangle >= triangle_count) {
        throw ConfigError("self-contact region", "triangle " + std::to_string(triangle),
                          "one of the " + std::to_string(triangle_count) + " triangles of the surface");
      }
      marks[triangle] = 1;
    }
    return marks;
  };
  pairs_.push_back({mark(triangles), mark(other_triangles)});
}

bool RegionPairs::allows(int triangle, int other_triangle) const {
  for (const Pair& pair : pairs_) {
    if (pair.first[triangle] && pair.second[other_triangle]) return true;
    if (pair.first[other_triangle] && pair.second[triangle]) return true;
  }
  return pairs_.empty();
}

SurfacePairs::SurfacePairs(const ProximitySettings& settings, int max_vertices, int max_other_vertices, int max_rows)
    : settings_(settings), filter_(settings), nearest_a_(max_vertices), nearest_b_(max_other_vertices) {
  deep_.reserve(max_rows);
}

void SurfacePairs::addPairs(const MovingSurface& a, const MovingSurface& b, NearPairs* near, int obstacle,
                            ContactList& list) {
  start(a, b, nullptr, obstacle, list);
  if (near != nullptr && near->update(a, b)) {
    seeListed(*near);
  } else {
    a.tree().forEachPair(b.tree(), filter_.reach(), [this](int ta, int tb) { visit(ta, tb); });
  }
  finishDeep();
}

void SurfacePairs::addOwnPairs(const MovingSurface& surface, NearPairs* near, const RegionPairs& regions,
                               ContactList& list) {
  start(surface, surface, &regions, kSelfContact, list);
  if (near != nullptr && near->update(surface, surface)) {
    seeListed(*near);
  } else {
    surface.tree().forEachOwnPair(filter_.reach(), [this](int ta, int tb) { visit(ta, tb); });
  }
  finishDeep();
}

void SurfacePairs::seeListed(const NearPairs& near) {
  for (const FeaturePair& pair : near.pairs()) {
    if (allows(pair.triangle_a, pair.triangle_b)) see(pair);
  }
  for (const NearPairs::TrianglePair& pair : near.trianglePairs()) {
    if (a_->tree().comesNear(pair.a, b_->tree(), pair.b, filter_.reach())) visit(pair.a, pair.b);
  }
}

void SurfacePairs::start(const MovingSurface& a, const MovingSurface& b, const RegionPairs* regions, int obstacle,
                         ContactList& list) {
  a_ = &a;
  b_ = &b;
  regions_ = regions;
  list_ = &list;
  obstacle_ = obstacle;
  std::fill(nearest_a_.begin(), nearest_a_.end(), kFar);
  std::fill(nearest_b_.begin(), nearest_b_.end(), kFar);
  deep_.clear();
}

void SurfacePairs::visit(int ta, int tb) {
  if (!allows(ta, tb)) return;
  forEachFeaturePair(a_->topology(), ta, b_->topology(), tb, [this](const FeaturePair& pair) { see(pair); });
}

inline void SurfacePairs::see(const FeaturePair& pair) {
  switch (pair.kind) {
    case PairKind::kVertexFace:
      return seeVertexFace(true, pair.a, pair.b);
    case PairKind::kFaceVertex:
      return seeVertexFace(false, pair.b, pair.a);
    case PairKind::kVertexEdge:
      return seeVertexEdge(true, pair.a, pair.b);
    case PairKind::kEdgeVertex:
      return seeVertexEdge(false, pair.b, pair.a);
    case PairKind::kVertexVertex:
      return seeVertexVertex(pair.a, pair.b);
    default:
      return seeEdgeEdge(pair.a, pair.b);
  }
}

void SurfacePairs::seeVertexFace(bool vertex_on_a, int vertex, int face) {
  const MovingSurface& of_vertex = side(vertex_on_a);
  const MovingSurface& of_face = side(!vertex_on_a);
  const Vec3& normal = of_face.faceNormal(face);
  if (of_vertex.vertexNormal(vertex).dot(normal) >= 0) return;
  const Vec3& x = of_vertex.position(vertex);
  const double distance = normal.dot(x - of_face.corner(face, 0));
  if (distance > filter_.widestAlarm() || distance < -settings_.max_depth) return;
  Vec3 weights;
  if (!of_face.projectsInto(face, x, &weights)) return;

  const SurfacePoint on_vertex = SurfacePoint::atVertex(of_vertex, vertex);
  const SurfacePoint on_face = SurfacePoint::onFace(of_face, face, weights);
  const double slope = of_vertex.calcVertexSlope(vertex, normal);
  double* nearest = nearestOf(vertex_on_a, vertex);
  if (vertex_on_a || isSelf()) {
    offer({PairKind::kVertexFace, vertex, face, on_vertex, on_face, normal, distance, slope,
           of_vertex.vertexArea(vertex)},
          nearest);
  } else {
    offer({PairKind::kFaceVertex, face, vertex, on_face, on_vertex, -normal, distance, slope, of_face.faceArea(face)},
          nearest);
  }
}

void SurfacePairs::seeVertexEdge(bool vertex_on_a, int vertex, int edge) {
  const MovingSurface& of_vertex = side(vertex_on_a);
  const MovingSurface& of_edge = side(!vertex_on_a);
  if (!facesOwn(of_vertex.vertexNormal(vertex), of_edge.edgeNormal(edge))) return;
  const Vec3& x = of_vertex.position(vertex);
  const auto& ends = of_edge.topology().edges()[edge].vertices;
  const Vec3& start = of_edge.position(ends[0]);
  const Vec3 along = of_edge.position(ends[1]) - start;
  const double t = along.dot(x - start) / along.squaredNorm();
  if (!(t >= -kTie && t <= 1 + kTie)) return;
  const Vec3 offset = x - start - t * along;
  const double distance = offset.norm();
  if (distance > filter_.widestAlarm() || distance < kTouching) return;

  const Vec3 normal = offset / distance;
  if (of_vertex.vertexNormal(vertex).dot(normal) >= 0 || of_edge.edgeNormal(edge).dot(normal) <= 0) return;
  const double vertex_slope = of_vertex.calcVertexSlope(vertex, normal);
  const double edge_slope = of_edge.calcEdgeSlope(edge, -normal);
  if (vertex_slope < -kTie && edge_slope < -kTie) return;
  const double slope = std::min(vertex_slope, edge_slope);
  const SurfacePoint on_vertex = SurfacePoint::atVertex(of_vertex, vertex);
  const SurfacePoint on_edge = SurfacePoint::onEdge(of_edge, edge, t);
  double* nearest = edge_slope >= -kTie ? nearestOf(vertex_on_a, vertex) : nullptr;
  if (vertex_on_a || isSelf()) {
    offer({PairKind::kVertexEdge, vertex, edge, on_vertex, on_edge, normal, distance, slope,
           of_vertex.vertexArea(vertex)},
          nearest);
  } else {
    offer({PairKind::kEdgeVertex, edge, vertex, on_edge, on_vertex, -normal, distance, slope, of_edge.edgeArea(edge)},
          nearest);
  }
}

void SurfacePairs::seeVertexVertex(int va, int vb) {
  if (isSelf() && va > vb) std::swap(va, vb);
  if (!facesOwn(a_->vertexNormal(va), b_->vertexNormal(vb))) return;
  const Vec3 offset = a_->position(va) - b_->position(vb);
  const double distance = offset.norm();
  if (distance > filter_.widestAlarm() || distance < kTouching) return;
  const Vec3 normal = offset / distance;
  if (a_->vertexNormal(va).dot(normal) >= 0 || b_->vertexNormal(vb).dot(normal) <= 0) return;
  const double slope_a = a_->calcVertexSlope(va, normal);
  const double slope_b = b_->calcVertexSlope(vb, -normal);
  if (slope_a < -kTie && slope_b < -kTie) return;
  offer({PairKind::kVertexVertex, va, vb, SurfacePoint::atVertex(*a_, va), SurfacePoint::atVertex(*b_, vb), normal,
         distance, std::min(slope_a, slope_b), a_->vertexArea(va)},
        slope_b >= -kTie ? nearestOf(true, va) : nullptr, slope_a >= -kTie ? nearestOf(false, vb) : nullptr);
}

void SurfacePairs::seeEdgeEdge(int ea, int eb) {
  if (isSelf() && ea > eb) std::swap(ea, eb);
  if (!facesOwn(a_->edgeNormal(ea), b_->edgeNormal(eb))) return;
  if (a_->bend(ea) < kLeastBend && b_->bend(eb) < kLeastBend) return;
  const auto& ends_a = a_->topology().edges()[ea].vertices;
  const auto& ends_b = b_->topology().edges()[eb].vertices;
  const LineMeeting meeting = calcLineMeeting(a_->position(ends_a[0]), a_->position(ends_a[1]), b_->position(ends_b[0]),
                                              b_->position(ends_b[1]));
  const auto isBetween = [](double t) { return t >= -kTie && t <= 1 + kTie; };
  if (meeting.is_parallel || !isBetween(meeting.s) || !isBetween(meeting.t)) return;
  const Vec3 normal = meeting.across.dot(b_->edgeNormal(eb)) > 0 ? meeting.across : Vec3(-meeting.across);
  if (a_->edgeNormal(ea).dot(normal) >= 0 || b_->edgeNormal(eb).dot(normal) <= 0) return;
  const SurfacePoint on_a = SurfacePoint::onEdge(*a_, ea, meeting.s);
  const SurfacePoint on_b = SurfacePoint::onEdge(*b_, eb, meeting.t);
  const double distance = normal.dot(on_a.position - on_b.position);
  if (distance > filter_.widestAlarm() || distance < -settings_.max_depth) return;
  const double slope = std::min(a_->calcEdgeSlope(ea, normal), b_->calcEdgeSlope(eb, -normal));
  offer({PairKind::kEdgeEdge, ea, eb, on_a, on_b, normal, distance, slope, a_->edgeArea(ea)}, nullptr);
}

// Features of one surface that share a vertex or an edge, or that are nearer than the contact distance already at rest,
// are held apart by the material. So is a feature from the other side of a thin wall.
bool SurfacePairs::keepsInOwn(const Pair& pair) const {
  const CollisionSurface& topology = a_->topology();
  for (int i = 0; i < pair.on_a.vertices; ++i) {
    for (int j = 0; j < pair.on_b.vertices; ++j) {
      const int va = pair.on_a.vertex[i], vb = pair.on_b.vertex[j];
      if (va == vb || topology.areNeighbours(va, vb)) return false;
    }
  }
  const double at_rest = (pair.on_a.calcRestPosition(*a_) - pair.on_b.calcRestPosition(*b_)).norm();
  const bool behind = pair.distance < 0;
  return at_rest > (behind ? kMaterialReach * settings_.max_depth : settings_.contact_distance);
}

void SurfacePairs::offer(const Pair& pair, double* nearest, double* other_nearest) {
  if (isSelf() && !keepsInOwn(pair)) return;
  for (double* const least : {nearest, other_nearest}) {
    if (least != nullptr) *least = std::min(*least, std::abs(pair.distance));
  }
  const std::uint64_t key = makeContactKey(obstacle_, pair.kind, pair.a, pair.b);
  if (!filter_.accepts(pair.distance, pair.slope, key, *list_)) return;
  if (pair.distance >= 0 || nearest == nullptr) return addRow(pair);
  if (deep_.size() < deep_.capacity()) deep_.push_back({pair, nearest});
}

// A vertex behind several faces is pushed out through the nearest only.
void SurfacePairs::finishDeep() {
  for (const Deep& deep : deep_) {
    if (-deep.pair.distance <= *deep.nearest + kTouching) addRow(deep.pair);
  }
}

void SurfacePairs::addRow(const Pair& pair) {
  ContactRow row;
  row.key = makeContactKey(obstacle_, pair.kind, pair.a, pair.b);
  row.obstacle = obstacle_;
  row.point = pair.on_a.position;
  row.other_point = pair.on_b.position;
  row.normal = pair.normal;
  row.gap = pair.distance - settings_.contact_distance;
  row.area = pair.area;
  ContactEntry entries[6];
  int count = 0;
  for (int i = 0; i < pair.on_a.vertices; ++i) {
    entries[count++] = {0, a_->topology().node(pair.on_a.vertex[i]), pair.on_a.weight[i] * pair.normal};
  }
  for (int i = 0; obstacle_ < 0 && i < pair.on_b.vertices; ++i) {
    entries[count++] = {isSelf() ? 0 : 1, b_->topology().node(pair.on_b.vertex[i]), -pair.on_b.weight[i] * pair.normal};
  }
  list_->add(row, entries, count);
}

}  // namespace sinew
