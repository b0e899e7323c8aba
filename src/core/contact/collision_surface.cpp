#include "sinew/contact/collision_surface.h"

#include <algorithm>
#include <tuple>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

/// A side of a triangle, `from` and `to` ordered.
struct Side {
  int low, high, triangle, side;
  bool is_forward;  // the triangle runs from low to high
};

std::vector<Side> makeSortedSides(const std::vector<CollisionSurface::Triangle>& triangles) {
  std::vector<Side> sides;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    for (int i = 0; i < 3; ++i) {
      const int from = triangles[t][i];
      const int to = triangles[t][(i + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), t, i, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return sides;
}

bool isPair(const std::vector<Side>& sides, std::size_t i) {
  const auto isSame = [&](std::size_t j) {
    return j < sides.size() && sides[j].low == sides[i].low && sides[j].high == sides[i].high;
  };
  return isSame(i + 1) && !isSame(i + 2) && sides[i].is_forward != sides[i + 1].is_forward;
}

}  // namespace

CollisionSurface::CollisionSurface(const std::vector<Triangle>& triangles) {
  if (triangles.empty()) throw ConfigError("collision surface", "no triangles", "at least four that close a volume");
  numberVertices(triangles);
  pairEdges();
  linkNeighbours();
}

void CollisionSurface::numberVertices(const std::vector<Triangle>& triangles) {
  for (const Triangle& triangle : triangles) nodes_.insert(nodes_.end(), triangle.begin(), triangle.end());
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());

  std::vector<char> is_owned(nodes_.size(), 0);
  for (const Triangle& triangle : triangles) {
    Triangle corners;
    Few owned;
    for (int i = 0; i < 3; ++i) {
      corners[i] = static_cast<int>(std::lower_bound(nodes_.begin(), nodes_.end(), triangle[i]) - nodes_.begin());
      if (!is_owned[corners[i]]) owned.add(corners[i]);
      is_owned[corners[i]] = 1;
    }
    triangles_.push_back(corners);
    owned_vertices_.push_back(owned);
  }
}

void CollisionSurface::pairEdges() {
  triangle_edges_.resize(triangles_.size());
  owned_edges_.resize(triangles_.size());
  const std::vector<Side> sides = makeSortedSides(triangles_);
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    if (!isPair(sides, i)) {
      throw ConfigError("collision surface: the edge between nodes " + std::to_string(nodes_[sides[i].low]) + " and " +
                            std::to_string(nodes_[sides[i].high]),
                        "not two triangles that pass through it in opposite directions",
                        "a closed surface without branches, all normals pointing out of the material");
    }
    const Side& forward = sides[sides[i].is_forward ? i : i + 1];
    const Side& backward = sides[sides[i].is_forward ? i + 1 : i];
    const auto opposite = [&](const Side& side) { return triangles_[side.triangle][(side.side + 2) % 3]; };
    for (const Side* side : {&forward, &backward}) {
      triangle_edges_[side->triangle][side->side] = static_cast<int>(edges_.size());
    }
    owned_edges_[forward.triangle].add(static_cast<int>(edges_.size()));
    edges_.push_back(
        {{forward.low, forward.high}, {forward.triangle, backward.triangle}, {opposite(forward), opposite(backward)}});
  }
}

void CollisionSurface::linkNeighbours() {
  std::vector<std::vector<int>> around(nodes_.size());
  for (const Edge& edge : edges_) {
    around[edge.vertices[0]].push_back(edge.vertices[1]);
    around[edge.vertices[1]].push_back(edge.vertices[0]);
  }
  fan_.push_back(0);
  for (std::vector<int>& list : around) {
    std::sort(list.begin(), list.end());
    neighbours_.insert(neighbours_.end(), list.begin(), list.end());
    fan_.push_back(static_cast<int>(neighbours_.size()));
  }
}

bool CollisionSurface::areNeighbours(int vertex, int other) const {
  const Range range = neighboursOf(vertex);
  return std::binary_search(range.begin(), range.end(), other);
}

}  // namespace sinew
