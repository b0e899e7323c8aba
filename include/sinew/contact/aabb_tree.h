#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// An axis-aligned box. Empty ones have lower > upper.
struct Box {
  Vec3 lower = Vec3::Constant(1e300);
  Vec3 upper = Vec3::Constant(-1e300);

  void extend(const Vec3& point) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  void extend(const Box& other) {
    lower = lower.cwiseMin(other.lower);
    upper = upper.cwiseMax(other.upper);
  }
  Box grown(double margin) const { return {lower - Vec3::Constant(margin), upper + Vec3::Constant(margin)}; }
  bool overlaps(const Box& other) const {
    return lower.x() <= other.upper.x() && other.lower.x() <= upper.x() && lower.y() <= other.upper.y() &&
           other.lower.y() <= upper.y() && lower.z() <= other.upper.z() && other.lower.z() <= upper.z();
  }
};

/// A box in four floats a corner, which one instruction compares. Rounded outwards; the last entries are 0.
struct PackedBox {
  Eigen::Vector4f lower, upper;

  PackedBox() = default;
  explicit PackedBox(const Box& box);
  void extend(const PackedBox& other) {
    lower = lower.cwiseMin(other.lower);
    upper = upper.cwiseMax(other.upper);
  }
  bool isWithin(float margin, const PackedBox& other) const {
    return (upper - other.lower).cwiseMin(other.upper - lower).minCoeff() >= -margin;
  }
  float squaredDistance(const Eigen::Vector4f& p) const {
    return (p - p.cwiseMax(lower).cwiseMin(upper)).squaredNorm();
  }
  float squaredDistance(const PackedBox& other) const {
    return (lower - other.upper).cwiseMax(other.lower - upper).cwiseMax(Eigen::Vector4f::Zero()).squaredNorm();
  }
  /// The smallest that a . b can be for a in this box and b in the other.
  float calcLeastDot(const PackedBox& other) const {
    const Eigen::Vector4f by_lower = lower.cwiseProduct(other.lower).cwiseMin(upper.cwiseProduct(other.lower));
    const Eigen::Vector4f by_upper = lower.cwiseProduct(other.upper).cwiseMin(upper.cwiseProduct(other.upper));
    return by_lower.cwiseMin(by_upper).sum();
  }
};

/// A binary tree of boxes over triangles whose corners move. Its shape is decided once from the positions at set-up;
/// `refit` follows the corners in one pass from the leaves up. One triangle a leaf; the left child follows its parent.
/// A second box in each node may hold the directions in which its triangles look.
class AabbTree {
 public:
  using Triangle = std::array<int, 3>;

  AabbTree(const std::vector<Triangle>& triangles, const std::vector<Vec3>& corners);

  void refit(const std::vector<Triangle>& triangles, const std::vector<Vec3>& corners);
  /// `normals`: for each triangle, a box around the normals of its features.
  void refitNormals(const std::vector<Box>& normals);
  const Box& box() const { return box_; }
  /// All triangles, those that were near each other at set-up close together. Allocates.
  std::vector<int> makeOrder() const;

  /// visit(triangle) for each whose box overlaps `box`.
  template <typename Visit>
  void forEachIn(const Box& box, const Visit& visit) const {
    searchBox(0, PackedBox(box), visit);
  }

  /// visit(triangle here, triangle of `other`) for each pair whose boxes come within `margin` [m].
  template <typename Visit>
  void forEachPair(const AabbTree& other, double margin, const Visit& visit) const {
    searchPairs<false>(*this, 0, other, 0, {calcLoosenedSquare(margin), 0}, visit);
  }

  /// Likewise within the tree, each pair of different triangles once, without some pairs all of whose normals (of at
  /// most unit length) have products above `facing`.
  template <typename Visit>
  void forEachOwnPair(double margin, const Visit& visit, double facing = 0) const {
    searchSelf(0, {calcLoosenedSquare(margin), static_cast<float>(facing) + kRounding}, visit);
  }

  /// Whether the boxes of two triangles come within `margin` [m].
  bool comesNear(int triangle, const AabbTree& other, int other_triangle, double margin) const {
    const PackedBox& box = nodes_[leaf_of_[triangle]].box;
    return box.squaredDistance(other.nodes_[other.leaf_of_[other_triangle]].box) <= calcLoosenedSquare(margin);
  }

  /// visit(triangle) returns a squared distance [m2]; triangles whose boxes are farther from `point` than the smallest
  /// answer so far are passed over, and nearer boxes come first.
  template <typename Visit>
  void forEachNear(const Vec3& point, const Visit& visit) const {
    float bound = kFar;
    searchNear(0, Eigen::Vector4f(float(point.x()), float(point.y()), float(point.z()), 0), bound, visit);
  }

 private:
  static constexpr float kFar = 1e30f;
  static constexpr float kRounding = 1e-5f;   // of a product of two directions
  static constexpr float kLoosening = 1e-4f;  // of a squared distance, and of a length in m, against rounding

  struct Node {
    PackedBox box, normals;
    int right;     // -1: a leaf
    int triangle;  // of a leaf
    float size;    // m, sum of the box's sides
  };

  int build(const std::vector<Triangle>& triangles, const std::vector<Vec3>& corners, int* first, int* last);
  bool isLeaf(int node) const { return nodes_[node].right < 0; }

  template <typename Visit>
  void searchBox(int at, const PackedBox& box, const Visit& visit) const {
    const Node& node = nodes_[at];
    if (!node.box.isWithin(0, box)) return;
    if (node.right < 0) return visit(node.triangle);
    searchBox(at + 1, box, visit);
    searchBox(node.right, box, visit);
  }

  static float calcLoosenedSquare(double margin) { return static_cast<float>(margin * margin) * (1 + kLoosening); }

  struct Limits {
    float squared_margin;  // m2
    float facing;          // product of normals
  };

  template <bool must_face>
  static bool mayMeet(const Node& a, const Node& b, const Limits& limits) {
    return a.box.squaredDistance(b.box) <= limits.squared_margin &&
           !(must_face && a.normals.calcLeastDot(b.normals) > limits.facing);
  }

  template <bool must_face, typename Visit>
  static void searchPairs(const AabbTree& a, int at, const AabbTree& b, int bt, const Limits& limits,
                          const Visit& visit) {
    const Node& na = a.nodes_[at];
    const Node& nb = b.nodes_[bt];
    if (!mayMeet<must_face>(na, nb, limits)) return;
    if (na.right < 0 && nb.right < 0) return visit(na.triangle, nb.triangle);
    if (nb.right < 0 || (na.right >= 0 && na.size >= nb.size)) {
      searchPairs<must_face>(a, at + 1, b, bt, limits, visit);
      searchPairs<must_face>(a, na.right, b, bt, limits, visit);
    } else {
      searchPairs<must_face>(a, at, b, bt + 1, limits, visit);
      searchPairs<must_face>(a, at, b, nb.right, limits, visit);
    }
  }

  template <typename Visit>
  void searchSelf(int at, const Limits& limits, const Visit& visit) const {
    if (isLeaf(at) || nodes_[at].normals.calcLeastDot(nodes_[at].normals) > limits.facing) return;
    searchSelf(at + 1, limits, visit);
    searchSelf(nodes_[at].right, limits, visit);
    searchPairs<true>(*this, at + 1, *this, nodes_[at].right, limits, visit);
  }

  template <typename Visit>
  void searchNear(int at, const Eigen::Vector4f& point, float& bound, const Visit& visit) const {
    const Node& node = nodes_[at];
    if (node.box.squaredDistance(point) > bound) return;
    if (node.right < 0) {
      bound = std::min(bound, static_cast<float>(visit(node.triangle)) * (1 + kLoosening) + kLoosening * kLoosening);
      return;
    }
    const bool right_first = nodes_[node.right].box.squaredDistance(point) < nodes_[at + 1].box.squaredDistance(point);
    searchNear(right_first ? node.right : at + 1, point, bound, visit);
    searchNear(right_first ? at + 1 : node.right, point, bound, visit);
  }

  std::vector<Node> nodes_;
  std::vector<int> leaf_of_;  // by triangle
  Box box_;
};

}  // namespace sinew
