#pragma once

#include <array>
#include <string>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// What is fixed about a closed triangle surface that moves: its vertices, each a node of some array of positions, and
/// how triangles, edges and vertices meet. Normals point out of the material: corners run counter-clockwise seen from
/// outside.
class CollisionSurface {
 public:
  using Triangle = std::array<int, 3>;

  struct Edge {
    std::array<int, 2> vertices;
    std::array<int, 2> triangles;  ///< the first runs through the edge from vertices[0] to vertices[1]
    std::array<int, 2> opposite;   ///< the vertex of each triangle that is not on the edge
  };

  struct Range {
    const int* first;
    const int* last;
    const int* begin() const { return first; }
    const int* end() const { return last; }
    int size() const { return static_cast<int>(last - first); }
  };

  /// `triangles` hold node indices. Throws ConfigError unless every edge belongs to two triangles that pass through it
  /// in opposite directions.
  explicit CollisionSurface(const std::vector<Triangle>& triangles);

  int vertices() const { return static_cast<int>(nodes_.size()); }
  int node(int vertex) const { return nodes_[vertex]; }
  const std::vector<Triangle>& triangles() const { return triangles_; }  ///< vertex indices
  const std::vector<Edge>& edges() const { return edges_; }
  /// Edge i of a triangle runs from its corner i to its corner i + 1.
  const std::array<int, 3>& edgesOf(int triangle) const { return triangle_edges_[triangle]; }
  Range neighboursOf(int vertex) const { return {&neighbours_[fan_[vertex]], &neighbours_[fan_[vertex + 1]]}; }
  bool areNeighbours(int vertex, int other) const;

  /// Every vertex and every edge is owned by one of its triangles, so that a walk over triangles meets it once.
  Range ownedVertices(int triangle) const { return owned_vertices_[triangle].range(); }
  Range ownedEdges(int triangle) const { return owned_edges_[triangle].range(); }

 private:
  struct Few {
    std::array<int, 3> items;
    int count = 0;
    void add(int item) { items[count++] = item; }
    Range range() const { return {items.data(), items.data() + count}; }
  };
  void numberVertices(const std::vector<Triangle>& triangles);
  void pairEdges();
  void linkNeighbours();

  std::vector<int> nodes_;
  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
  std::vector<std::array<int, 3>> triangle_edges_;
  std::vector<int> fan_, neighbours_;  // neighbours of vertex v: fan_[v] .. fan_[v + 1], ascending
  std::vector<Few> owned_vertices_, owned_edges_;
};

}  // namespace sinew
