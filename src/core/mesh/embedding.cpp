#include "sinew/mesh/embedding.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/common/config_error.h"
#include "sinew/mesh/surface.h"

namespace sinew {
namespace {

using Box = Eigen::AlignedBox3d;
using Corners = std::array<Vec3, 4>;

constexpr int kLeafSize = 4;
/// |6 volume| / (longest edge)^3 below which a tetrahedron carries no point: its weights would be noise.
constexpr double kFlat = 1e-9;
/// Distances that differ by less than this part of the size of the mesh count as equal.
constexpr double kTie = 1e-12;

Mat3 calcEdges(const Corners& x) {
  Mat3 edges;
  edges << x[1] - x[0], x[2] - x[0], x[3] - x[0];
  return edges;
}

bool isFlat(const Corners& x) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) longest = std::max(longest, (x[i] - x[j]).norm());
  }
  return !(std::abs(calcEdges(x).determinant()) > kFlat * longest * longest * longest);
}

/// Barycentric coordinates of p, refined once so that thin tetrahedra reproduce it too.
Vec4 calcWeights(const Corners& x, const Vec3& p) {
  const Mat3 edges = calcEdges(x);
  const Eigen::FullPivLU<Mat3> lu(edges);
  Vec3 w = lu.solve(p - x[0]);
  w += lu.solve(p - x[0] - edges * w);
  return {1 - w.sum(), w[0], w[1], w[2]};
}

double calcSquaredDistanceToSegment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 edge = b - a;
  const double along = std::min(1.0, std::max(0.0, edge.dot(p - a) / edge.squaredNorm()));
  return (a + along * edge - p).squaredNorm();
}

double calcSquaredDistanceToTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 normal = (b - a).cross(c - a);
  const bool above = (b - a).cross(p - a).dot(normal) >= 0 && (c - b).cross(p - b).dot(normal) >= 0 &&
                     (a - c).cross(p - c).dot(normal) >= 0;
  if (above) {
    const double height = normal.dot(p - a);
    return height * height / normal.squaredNorm();
  }
  return std::min({calcSquaredDistanceToSegment(a, b, p), calcSquaredDistanceToSegment(b, c, p),
                   calcSquaredDistanceToSegment(c, a, p)});
}

double calcDistance(const Corners& x, const Vec4& weights, const Vec3& p) {
  if (weights.minCoeff() >= 0) return 0;
  double squared = std::numeric_limits<double>::infinity();
  for (const std::array<int, 3>& side : kTetSides) {
    const auto corner = [&](std::size_t i) -> const Vec3& { return x[static_cast<std::size_t>(side[i])]; };
    squared = std::min(squared, calcSquaredDistanceToTriangle(corner(0), corner(1), corner(2), p));
  }
  return std::sqrt(squared);
}

}  // namespace

/// A binary tree over the boxes of the tetrahedra, stored depth first: the left child follows its parent.
struct PointLocator::Impl {
  struct Tet {
    Corners corners;
    std::array<int, 4> nodes;
    int index;
    Box box;
  };
  struct Branch {
    Box box;
    int begin, end;  // range of tets below
    int right = -1;  // -1: a leaf
  };

  std::vector<Tet> tets;
  std::vector<Branch> branches;
  double tie = 0;  // m

  explicit Impl(const TetMesh& mesh);
  void addTet(const TetMesh& mesh, int index);
  void split(int begin, int end);
  void search(std::size_t branch, const Vec3& p, Result& best) const;
  void compare(const Tet& tet, const Vec3& p, Result& best) const;
};

PointLocator::Impl::Impl(const TetMesh& mesh) {
  tets.reserve(mesh.tets.size());
  for (int i = 0; i < static_cast<int>(mesh.tets.size()); ++i) addTet(mesh, i);
  if (tets.empty()) throw ConfigError("mesh", "no tetrahedron with a volume", "at least one to embed points in");
  split(0, static_cast<int>(tets.size()));
  tie = kTie * branches.front().box.diagonal().norm();
}

void PointLocator::Impl::addTet(const TetMesh& mesh, int index) {
  Tet tet;
  tet.index = index;
  tet.nodes = mesh.tets[static_cast<std::size_t>(index)];
  for (std::size_t i = 0; i < 4; ++i) {
    tet.corners[i] = mesh.nodes[static_cast<std::size_t>(tet.nodes[i])];
    tet.box.extend(tet.corners[i]);
  }
  if (!isFlat(tet.corners)) tets.push_back(tet);
}

void PointLocator::Impl::split(int begin, int end) {
  const std::size_t self = branches.size();
  Box box, centers;
  for (int i = begin; i < end; ++i) {
    const Box& below = tets[static_cast<std::size_t>(i)].box;
    box.extend(below);
    centers.extend(below.center());
  }
  branches.push_back({box, begin, end});
  if (end - begin <= kLeafSize) return;

  Eigen::Index axis;
  centers.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(tets.begin() + begin, tets.begin() + middle, tets.begin() + end,
                   [axis](const Tet& a, const Tet& b) { return a.box.center()[axis] < b.box.center()[axis]; });
  split(begin, middle);
  branches[self].right = static_cast<int>(branches.size());
  split(middle, end);
}

void PointLocator::Impl::search(std::size_t branch, const Vec3& p, Result& best) const {
  const Branch& here = branches[branch];
  if (here.box.exteriorDistance(p) > best.distance + tie) return;
  if (here.right < 0) {
    for (int i = here.begin; i < here.end; ++i) compare(tets[static_cast<std::size_t>(i)], p, best);
    return;
  }
  std::size_t near = branch + 1;
  std::size_t far = static_cast<std::size_t>(here.right);
  const bool is_swapped = branches[far].box.squaredExteriorDistance(p) < branches[near].box.squaredExteriorDistance(p);
  if (is_swapped) std::swap(near, far);
  search(near, p, best);
  search(far, p, best);
}

void PointLocator::Impl::compare(const Tet& tet, const Vec3& p, Result& best) const {
  if (tet.box.exteriorDistance(p) > best.distance + tie) return;
  const Vec4 weights = calcWeights(tet.corners, p);
  const double distance = calcDistance(tet.corners, weights, p);
  const bool nearer = distance < best.distance - tie;
  const bool as_near = distance <= best.distance + tie;
  if (nearer || (as_near && weights.minCoeff() > best.point.weights.minCoeff())) {
    best.point.nodes = tet.nodes;
    best.point.weights = weights;
    best.tet = tet.index;
    best.distance = distance;
  }
}

PointLocator::PointLocator(const TetMesh& mesh) : impl_(new Impl(mesh)) {}
PointLocator::~PointLocator() = default;

PointLocator::Result PointLocator::locate(const Vec3& position) const {
  if (!std::isfinite(position.squaredNorm())) {
    throw ConfigError("point to embed", "a coordinate that is not finite", "a position in metres");
  }
  Result best;
  best.distance = std::numeric_limits<double>::infinity();
  impl_->search(0, position, best);
  return best;
}

}  // namespace sinew
