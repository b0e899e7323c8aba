#pragma once

#include <array>

#include "sinew/fem/fem_model.h"
#include "sinew/mesh/embedding.h"

namespace sinew {

/// Couples two points of the body, or one point and the world, by a 3x3 stiffness along the straight line between them:
/// adds w_i w_j B to the tangent for the nodes i, j of the segment, with weights negative at the first end.
class SegmentStiffness {
 public:
  /// `first` null: that end is fixed in the world.
  SegmentStiffness(const FemModel& model, const EmbeddedPoint* first, const EmbeddedPoint& second);

  /// The mesh nodes that such a segment couples, for the sparsity pattern.
  static std::vector<int> coupledNodes(const EmbeddedPoint* first, const EmbeddedPoint& second);

  void addTo(BlockMatrix& matrix, const Mat3& stiffness) const;

 private:
  struct Block {
    BlockSlot slot;
    double weight;
  };
  std::vector<Block> blocks_;
};

}  // namespace sinew
