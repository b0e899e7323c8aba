#pragma once

#include <vector>

#include "sinew/contact/feature_pair.h"
#include "sinew/contact/moving_surface.h"
#include "sinew/contact/surface_snapshot.h"

namespace sinew {

/// A feature of one surface and one of another, and the triangles that own them. A vertex is on the first surface in
/// kVertexFace and kVertexEdge, on the second in kFaceVertex and kEdgeVertex.
struct FeaturePair {
  PairKind kind;
  int a, b;
  int triangle_a, triangle_b;
};

/// see(pair) for all pairs of features owned by triangle `ta` of `a` and `tb` of `b`.
template <typename See>
void forEachFeaturePair(const CollisionSurface& a, int ta, const CollisionSurface& b, int tb, const See& see) {
  for (const int va : a.ownedVertices(ta)) {
    see(FeaturePair{PairKind::kVertexFace, va, tb, ta, tb});
    for (const int eb : b.ownedEdges(tb)) see(FeaturePair{PairKind::kVertexEdge, va, eb, ta, tb});
    for (const int vb : b.ownedVertices(tb)) see(FeaturePair{PairKind::kVertexVertex, va, vb, ta, tb});
  }
  for (const int vb : b.ownedVertices(tb)) {
    see(FeaturePair{PairKind::kFaceVertex, ta, vb, ta, tb});
    for (const int ea : a.ownedEdges(ta)) see(FeaturePair{PairKind::kEdgeVertex, ea, vb, ta, tb});
  }
  for (const int ea : a.ownedEdges(ta)) {
    for (const int eb : b.ownedEdges(tb)) see(FeaturePair{PairKind::kEdgeEdge, ea, eb, ta, tb});
  }
}

/// The pairs of two surfaces, or of one with itself, that can become contacts until their parts have moved against each
/// other by more than a skin, or a normal has turned by more than 0.05 rad (after Verlet, Computer experiments on
/// classical fluids I, Phys. Rev. 159, 1967). First these are pairs of triangles; cycle by cycle some of them are
/// replaced by the pairs of their features, without those that cannot be a contact before that:
/// - farther apart than reach and skin;
/// - in self-contact: neighbours, and normals that do not face each other;
/// - that see each other from behind, from farther than the greatest depth;
/// - two edges neither of which bends outwards.
/// When most of the skin is used up, the search for the next list falls into a cycle that the old one still serves.
class NearPairs {
 public:
  struct TrianglePair {
    int a, b;
  };

  /// Of surface `a` with `b`, which may be `a`.
  NearPairs(const ProximitySettings& settings, const MovingSurface& a, const MovingSurface& b);

  /// Follows the surfaces; allocates nothing. False if there is no list: they have moved too far in too few cycles for
  /// one to be worth its search, or more triangles are near than there is room for.
  bool update(const MovingSurface& a, const MovingSurface& b);
  bool hasList() const { return state_ == State::kListed; }
  const std::vector<FeaturePair>& pairs() const { return pairs_; }
  const std::vector<TrianglePair>& trianglePairs() const { return triangle_pairs_; }  ///< not yet among `pairs`

 private:
  enum class State { kNone, kListed, kFull };

  double updateWear(const MovingSurface& a, const MovingSurface& b);
  void take(const MovingSurface& a, const MovingSurface& b);
  bool collect(const MovingSurface& a, const MovingSurface& b);
  void swapNext();
  void sortSome(const MovingSurface& a, const MovingSurface& b);
  bool canMeet(const MovingSurface& a, const MovingSurface& b, const FeaturePair& pair) const;
  const SurfaceSnapshot& snapshotB() const { return is_self_ ? snapshot_a_ : snapshot_b_; }

  double max_depth_, reach_, skin_;  // m
  bool is_self_;
  SurfaceSnapshot snapshot_a_, snapshot_b_;  // b's is idle in self-contact
  std::vector<double> room_for_motion_;      // m, by part of a and of b: of one against the other
  int age_;                                  // cycles that the snapshots have lasted, up to those that count as steady
  State state_ = State::kNone;
  bool has_next_ = false;  // pairs_ serve one cycle more, then next_triangle_pairs_
  std::vector<TrianglePair> triangle_pairs_, next_triangle_pairs_;
  std::vector<FeaturePair> pairs_;
};

}  // namespace sinew
