#include "sinew/constraint/segment_stiffness.h"

#include <map>

namespace sinew {

SegmentStiffness::SegmentStiffness(const FemModel& model, const EmbeddedPoint* first, const EmbeddedPoint& second) {
  std::map<int, double> weights;  // by free node; both ends may share nodes
  for (int i = 0; i < 4; ++i) {
    if (first != nullptr) weights[model.freeIndex(first->nodes[i])] -= first->weights[i];
    weights[model.freeIndex(second.nodes[i])] += second.weights[i];
  }
  weights.erase(-1);
  for (const auto& [row, row_weight] : weights) {
    for (const auto& [column, column_weight] : weights) {
      if (row >= column) blocks_.push_back({model.pattern().slot(row, column), row_weight * column_weight});
    }
  }
}

std::vector<int> SegmentStiffness::coupledNodes(const EmbeddedPoint* first, const EmbeddedPoint& second) {
  std::vector<int> nodes(second.nodes.begin(), second.nodes.end());
  if (first != nullptr) nodes.insert(nodes.end(), first->nodes.begin(), first->nodes.end());
  return nodes;
}

void SegmentStiffness::addTo(BlockMatrix& matrix, const Mat3& stiffness) const {
  for (const Block& block : blocks_) matrix.add(block.slot, block.weight * stiffness);
}

}  // namespace sinew
