#pragma once

#include <vector>

#include "sinew/linalg/block_matrix.h"

namespace sinew {

/// Orders in which the blocks of a symmetric matrix may be eliminated so that its factor stays sparse; entry k is the
/// block that is eliminated k-th. All see the blocks only, not the three degrees of freedom in each.
using BlockOrder = std::vector<int>;

/// Approximate minimum degree: for irregular meshes.
BlockOrder orderByMinimumDegree(const BlockPattern& pattern);
/// Nested dissection (METIS): for compact bodies.
BlockOrder orderByNestedDissection(const BlockPattern& pattern);
/// Along a slender body, from both of its ends to the middle: layers of equal distance from the end.
BlockOrder orderFromBothEnds(const BlockPattern& pattern);

/// Neighbours of every block, both triangles, without itself.
struct BlockGraph {
  std::vector<int> start;  ///< blocks + 1
  std::vector<int> neighbour;

  explicit BlockGraph(const BlockPattern& pattern);
  int blocks() const { return static_cast<int>(start.size()) - 1; }
};

}  // namespace sinew
