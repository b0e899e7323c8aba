#include "sinew/contact/near_pairs.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr double kSkin = 0.4;    // of the reach
constexpr double kTurn = 0.05;   // rad
constexpr double kSlack = 1e-3;  // of the reach, against rounding and ties
constexpr double kFar = 1e300;
constexpr double kWorn = 0.85;  // part of the skin from which the next list is made while this one serves
constexpr int kSteady = 3;      // cycles that a snapshot must have lasted for a list to be worth its search
constexpr int kSortedPerCycle = 3000;
constexpr int kMostOfTriangles = 42;           // pairs of their features
constexpr int kPairsPerVertex = 32;            // room in the list
const double kFacing = std::sin(2.1 * kTurn);  // cosine from which normals stay less than a right angle apart

using Feature = SurfaceSnapshot::Feature;

Feature featureOfA(PairKind kind) {
  if (kind == PairKind::kFaceVertex) return Feature::kFace;
  return kind == PairKind::kEdgeVertex || kind == PairKind::kEdgeEdge ? Feature::kEdge : Feature::kVertex;
}

Feature featureOfB(PairKind kind) {
  if (kind == PairKind::kVertexFace) return Feature::kFace;
  return kind == PairKind::kVertexEdge || kind == PairKind::kEdgeEdge ? Feature::kEdge : Feature::kVertex;
}

CollisionSurface::Range cornersOf(const CollisionSurface& topology, Feature feature, const int& index) {
  if (feature == Feature::kVertex) return {&index, &index + 1};
  if (feature == Feature::kEdge)
    return {topology.edges()[index].vertices.data(), topology.edges()[index].vertices.data() + 2};
  return {topology.triangles()[index].data(), topology.triangles()[index].data() + 3};
}

bool areNeighbours(const CollisionSurface& topology, const CollisionSurface::Range& a,
                   const CollisionSurface::Range& b) {
  for (const int va : a) {
    for (const int vb : b) {
      if (va == vb || topology.areNeighbours(va, vb)) return true;
    }
  }
  return false;
}

/// By how much all corners `a` lie above all `b` along `direction` [m].
double calcRise(const SurfaceSnapshot& at_a, const CollisionSurface::Range& a, const SurfaceSnapshot& at_b,
                const CollisionSurface::Range& b, const Vec3& direction) {
  double lowest = kFar, highest = -kFar;
  for (const int corner : a) lowest = std::min(lowest, direction.dot(at_a.position(corner)));
  for (const int corner : b) highest = std::max(highest, direction.dot(at_b.position(corner)));
  return lowest - highest;
}

double calcSquaredGap(const Box& a, const Box& b) {
  return (a.lower - b.upper).cwiseMax(b.lower - a.upper).cwiseMax(Vec3::Zero()).squaredNorm();
}

/// At least that of any vector in `a` from any in `b`.
double calcSquaredDifference(const Box& a, const Box& b) {
  return (a.upper - b.lower).cwiseMax(b.upper - a.lower).squaredNorm();
}

}  // namespace

NearPairs::NearPairs(const ProximitySettings& settings, const MovingSurface& a, const MovingSurface& b)
    : max_depth_(settings.max_depth),
      reach_((1 + kSlack) * PairFilter(settings).reach()),
      skin_(kSkin * reach_),
      is_self_(&a == &b),
      snapshot_a_(a),
      snapshot_b_(b),
      room_for_motion_(static_cast<std::size_t>(snapshot_a_.parts()) * static_cast<std::size_t>(snapshot_b_.parts())),
      age_(kSteady) {
  const auto vertices =
      static_cast<std::size_t>(a.topology().vertices()) + static_cast<std::size_t>(b.topology().vertices());
  triangle_pairs_.reserve(kPairsPerVertex * vertices);
  next_triangle_pairs_.reserve(kPairsPerVertex * vertices);
  pairs_.reserve(kPairsPerVertex * vertices);
}

bool NearPairs::update(const MovingSurface& a, const MovingSurface& b) {
  if (has_next_) swapNext();
  const double worn = updateWear(a, b);
  const bool stays = worn <= 1;
  if (stays) age_ = std::min(age_ + 1, kSteady);
  if (stays && hasList()) sortSome(a, b);
  const bool is_early = stays && hasList() && worn > kWorn && age_ == kSteady && triangle_pairs_.empty();
  if (stays && !is_early && (state_ != State::kNone || age_ < kSteady)) return hasList();
  take(a, b);
  state_ = age_ < kSteady ? State::kNone : collect(a, b) ? State::kListed : State::kFull;
  age_ = 0;
  has_next_ = hasList();
  if (has_next_ && !is_early) swapNext();
  return hasList();
}

void NearPairs::swapNext() {
  triangle_pairs_.swap(next_triangle_pairs_);
  pairs_.clear();
  has_next_ = false;
}

// The part of the room for motion that is used up; more than 1 where that or a turn is too much.
double NearPairs::updateWear(const MovingSurface& a, const MovingSurface& b) {
  if (!snapshot_a_.keepsDirections(a, kTurn)) return 2;
  if (!is_self_ && !snapshot_b_.keepsDirections(b, kTurn)) return 2;
  snapshot_a_.updateMotion(a);
  if (!is_self_) snapshot_b_.updateMotion(b);
  double worn = 0;
  std::size_t next = 0;
  for (int i = 0; i < snapshot_a_.parts(); ++i) {
    for (int j = 0; j < snapshotB().parts(); ++j) {
      const double room = room_for_motion_[next++];
      worn = std::max(worn, calcSquaredDifference(snapshot_a_.motion(i), snapshotB().motion(j)) / (room * room));
    }
  }
  return std::sqrt(worn);
}

void NearPairs::take(const MovingSurface& a, const MovingSurface& b) {
  snapshot_a_.take(a);
  if (!is_self_) snapshot_b_.take(b);
  std::size_t next = 0;
  for (int i = 0; i < snapshot_a_.parts(); ++i) {
    for (int j = 0; j < snapshotB().parts(); ++j) {
      const double apart = std::sqrt(calcSquaredGap(snapshot_a_.place(i), snapshotB().place(j)));
      room_for_motion_[next++] = std::max(skin_, apart - reach_);
    }
  }
}

bool NearPairs::collect(const MovingSurface& a, const MovingSurface& b) {
  next_triangle_pairs_.clear();
  bool has_room = true;
  const auto visit = [&](int ta, int tb) {
    has_room = has_room && next_triangle_pairs_.size() < next_triangle_pairs_.capacity();
    if (has_room) next_triangle_pairs_.push_back({ta, tb});
  };
  if (is_self_) {
    a.tree().forEachOwnPair(reach_ + skin_, visit, kFacing);
  } else {
    a.tree().forEachPair(b.tree(), reach_ + skin_, visit);
  }
  return has_room;
}

void NearPairs::sortSome(const MovingSurface& a, const MovingSurface& b) {
  for (int i = 0; i < kSortedPerCycle && !triangle_pairs_.empty(); ++i) {
    if (pairs_.size() + kMostOfTriangles > pairs_.capacity()) return;
    const TrianglePair triangles = triangle_pairs_.back();
    triangle_pairs_.pop_back();
    forEachFeaturePair(a.topology(), triangles.a, b.topology(), triangles.b, [&](const FeaturePair& pair) {
      if (canMeet(a, b, pair)) pairs_.push_back(pair);
    });
  }
}

bool NearPairs::canMeet(const MovingSurface& a, const MovingSurface& b, const FeaturePair& pair) const {
  const SurfaceSnapshot& at_a = snapshot_a_;
  const SurfaceSnapshot& at_b = snapshotB();
  const Feature kind_a = featureOfA(pair.kind), kind_b = featureOfB(pair.kind);
  const auto widest = static_cast<float>(reach_ + skin_);
  const Vec3& direction_a = at_a.direction(kind_a, pair.a);
  const Vec3& direction_b = at_b.direction(kind_b, pair.b);
  const bool is_far = at_a.box(kind_a, pair.a).squaredDistance(at_b.box(kind_b, pair.b)) > widest * widest;
  const bool looks_alike = is_self_ & (direction_a.dot(direction_b) > kFacing);
  if (is_far | looks_alike) return false;  // one jump that is mostly taken, rather than two that cannot be predicted

  // Now and later, faces look within kTurn of the snapshot.
  constexpr double kFlat = kLeastBend - 4 * kTurn;
  if (pair.kind == PairKind::kEdgeEdge && a.bend(pair.a) < kFlat && b.bend(pair.b) < kFlat) return false;
  const CollisionSurface::Range on_a = cornersOf(a.topology(), kind_a, pair.a);
  const CollisionSurface::Range on_b = cornersOf(b.topology(), kind_b, pair.b);
  const bool has_depth = on_a.size() + on_b.size() == 4;  // vertex and face, two edges
  const double limit = (has_depth ? max_depth_ : 0) + skin_ + (kTurn + kSlack) * reach_;
  if (calcRise(at_a, on_a, at_b, on_b, direction_a) > limit) return false;
  if (calcRise(at_b, on_b, at_a, on_a, direction_b) > limit) return false;
  return !(is_self_ && areNeighbours(a.topology(), on_a, on_b));
}

}  // namespace sinew
