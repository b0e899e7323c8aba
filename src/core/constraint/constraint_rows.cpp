#include "sinew/constraint/constraint_rows.h"

namespace sinew {

ConstraintRows::ConstraintRows(const FemModel& model, int max_rows, int max_entries)
    : model_(&model), blocks_(max_rows, max_entries) {
  translation_.reserve(static_cast<std::size_t>(max_rows));
}

void ConstraintRows::clear() {
  blocks_.clear();
  translation_.clear();
}

void ConstraintRows::beginRow() {
  blocks_.beginRow();
  translation_.push_back(Vec3::Zero());
}

void ConstraintRows::add(int mesh_node, const Vec3& derivative) {
  translation_.back() += derivative;
  const int node = model_->freeIndex(mesh_node);
  if (node >= 0) blocks_.add(node, derivative);
}

void ConstraintRows::add(const EmbeddedPoint& point, const Vec3& derivative) {
  for (int i = 0; i < 4; ++i) add(point.nodes[i], point.weights[i] * derivative);
}

double ConstraintRows::dot(int row, const VecX& x) const {
  double sum = 0;
  for (const auto* entry = blocks_.begin(row); entry != blocks_.end(row); ++entry) {
    sum += entry->derivative.dot(x.segment<3>(3 * entry->block));
  }
  return sum;
}

void ConstraintRows::addTransposed(int row, double factor, VecX& force) const {
  for (const auto* entry = blocks_.begin(row); entry != blocks_.end(row); ++entry) {
    force.segment<3>(3 * entry->block) += factor * entry->derivative;
  }
}

Vec3 calcPosition(const EmbeddedPoint& point, const std::vector<Vec3>& positions) {
  Vec3 position = Vec3::Zero();
  for (int i = 0; i < 4; ++i) position += point.weights[i] * positions[point.nodes[i]];
  return position;
}

}  // namespace sinew
