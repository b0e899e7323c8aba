#pragma once

#include <functional>
#include <vector>

#include "sinew/contact/contact_list.h"
#include "sinew/contact/feature_pair.h"
#include "sinew/contact/moving_surface.h"
#include "sinew/contact/near_pairs.h"

namespace sinew {

/// Which triangles of one surface may touch which: everything, or pairs of named regions.
class RegionPairs {
 public:
  /// Every triangle may touch every other.
  RegionPairs() = default;
  /// Only those of one set with those of the other (which may be the same set).
  void add(const std::vector<int>& triangles, const std::vector<int>& other_triangles, int triangle_count);
  bool allows(int triangle, int other_triangle) const;

 private:
  struct Pair {
    std::vector<char> first, second;  // by triangle
  };
  std::vector<Pair> pairs_;
};

/// Contacts of vertices, edges and faces of two triangle surfaces, or of one with itself.
class SurfacePairs {
 public:
  /// Makes room for surfaces of at most these numbers of vertices.
  SurfacePairs(const ProximitySettings& settings, int max_vertices, int max_other_vertices, int max_rows);

  /// `obstacle` is an index, and `b` rigid: it has no entries; or it is kOtherSurface, and b's are those of surface 1.
  /// `near`, of these two surfaces from cycle to cycle, saves time and changes no row; it may be null.
  void addPairs(const MovingSurface& a, const MovingSurface& b, NearPairs* near, int obstacle, ContactList& list);
  void addOwnPairs(const MovingSurface& surface, NearPairs* near, const RegionPairs& regions, ContactList& list);

 private:
  struct Pair {
    PairKind kind;
    int a, b;
    SurfacePoint on_a, on_b;
    Vec3 normal;  // unit, from b to a
    double distance, slope, area;
  };
  struct Deep {
    Pair pair;
    const double* nearest;  // of the vertex that lies behind a face
  };

  void start(const MovingSurface& a, const MovingSurface& b, const RegionPairs* regions, int obstacle,
             ContactList& list);
  void finishDeep();
  bool allows(int ta, int tb) const { return regions_ == nullptr || regions_->allows(ta, tb); }
  void seeListed(const NearPairs& near);
  void visit(int ta, int tb);
  void see(const FeaturePair& pair);
  void seeVertexFace(bool vertex_on_a, int vertex, int face);
  void seeVertexEdge(bool vertex_on_a, int vertex, int edge);
  void seeVertexVertex(int va, int vb);
  void seeEdgeEdge(int ea, int eb);
  bool isSelf() const { return a_ == b_; }
  bool facesOwn(const Vec3& normal_a, const Vec3& normal_b) const { return !isSelf() || normal_a.dot(normal_b) < 0; }
  const MovingSurface& side(bool on_a) const { return on_a ? *a_ : *b_; }
  double* nearestOf(bool on_a, int vertex) { return &(on_a || isSelf() ? nearest_a_ : nearest_b_)[vertex]; }
  bool keepsInOwn(const Pair& pair) const;
  void offer(const Pair& pair, double* nearest, double* other_nearest = nullptr);
  void addRow(const Pair& pair);

  ProximitySettings settings_;
  PairFilter filter_;
  std::vector<double> nearest_a_, nearest_b_;  // m, by vertex: to the nearest feature of the other side
  std::vector<Deep> deep_;
  const MovingSurface* a_ = nullptr;
  const MovingSurface* b_ = nullptr;
  const RegionPairs* regions_ = nullptr;
  ContactList* list_ = nullptr;
  int obstacle_ = 0;
};

}  // namespace sinew
