#include "sinew/contact/aabb_tree.h"

#include <cmath>
#include <numeric>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

const Box kAllDirections = {Vec3::Constant(-1), Vec3::Constant(1)};

Box calcBox(const AabbTree::Triangle& triangle, const std::vector<Vec3>& corners) {
  Box box;
  for (const int corner : triangle) box.extend(corners[corner]);
  return box;
}

Vec3 calcCentre(const AabbTree::Triangle& triangle, const std::vector<Vec3>& corners) {
  return (corners[triangle[0]] + corners[triangle[1]] + corners[triangle[2]]) / 3;
}

/// At least the rounding of a float of this size.
float calcRounding(double value) {
  return static_cast<float>(std::abs(value)) * 1e-6f + 1e-30f;
}

}  // namespace

PackedBox::PackedBox(const Box& box) : lower(Eigen::Vector4f::Zero()), upper(Eigen::Vector4f::Zero()) {
  for (int i = 0; i < 3; ++i) {
    lower[i] = static_cast<float>(box.lower[i]) - calcRounding(box.lower[i]);
    upper[i] = static_cast<float>(box.upper[i]) + calcRounding(box.upper[i]);
  }
}

AabbTree::AabbTree(const std::vector<Triangle>& triangles, const std::vector<Vec3>& corners) {
  if (triangles.empty()) throw ConfigError("collision surface", "no triangles", "at least one");
  std::vector<int> order(triangles.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * triangles.size());
  build(triangles, corners, order.data(), order.data() + order.size());
  leaf_of_.resize(triangles.size());
  for (int at = 0; at < static_cast<int>(nodes_.size()); ++at) {
    if (isLeaf(at)) leaf_of_[nodes_[at].triangle] = at;
  }
  refit(triangles, corners);
}

int AabbTree::build(const std::vector<Triangle>& triangles, const std::vector<Vec3>& corners, int* first, int* last) {
  const int self = static_cast<int>(nodes_.size());
  nodes_.push_back({PackedBox(Box{Vec3::Zero(), Vec3::Zero()}), PackedBox(kAllDirections), -1, *first, 0});
  if (last - first == 1) return self;

  Box centres;
  for (const int* t = first; t != last; ++t) centres.extend(calcCentre(triangles[*t], corners));
  Eigen::Index axis;
  (centres.upper - centres.lower).maxCoeff(&axis);
  int* middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [&](int a, int b) {
    const double at_a = calcCentre(triangles[a], corners)[axis];
    const double at_b = calcCentre(triangles[b], corners)[axis];
    return at_a < at_b || (at_a == at_b && a < b);
  });
  build(triangles, corners, first, middle);
  nodes_[self].right = build(triangles, corners, middle, last);
  return self;
}

void AabbTree::refit(const std::vector<Triangle>& triangles, const std::vector<Vec3>& corners) {
  box_ = Box();
  for (int at = static_cast<int>(nodes_.size()) - 1; at >= 0; --at) {
    Node& node = nodes_[at];
    if (node.right < 0) {
      const Box box = calcBox(triangles[node.triangle], corners);
      node.box = PackedBox(box);
      box_.extend(box);
    } else {
      node.box = nodes_[at + 1].box;
      node.box.extend(nodes_[node.right].box);
    }
    node.size = (node.box.upper - node.box.lower).sum();
  }
}

std::vector<int> AabbTree::makeOrder() const {
  std::vector<int> order;
  for (const Node& node : nodes_) {
    if (node.right < 0) order.push_back(node.triangle);
  }
  return order;
}

void AabbTree::refitNormals(const std::vector<Box>& normals) {
  for (int at = static_cast<int>(nodes_.size()) - 1; at >= 0; --at) {
    Node& node = nodes_[at];
    if (node.right < 0) {
      node.normals = PackedBox(normals[node.triangle]);
    } else {
      node.normals = nodes_[at + 1].normals;
      node.normals.extend(nodes_[node.right].normals);
    }
  }
}

}  // namespace sinew
