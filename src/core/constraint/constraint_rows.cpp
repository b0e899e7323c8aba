#include "sinew/constraint/constraint_rows.h"

namespace sinew {

ConstraintRows::ConstraintRows(const FemModel& model, int max_rows, int max_entries) : model_(&model) {
  start_.reserve(static_cast<std::size_t>(max_rows));
  translation_.reserve(static_cast<std::size_t>(max_rows));
  entries_.reserve(static_cast<std::size_t>(max_entries));
}

void ConstraintRows::clear() {
  start_.clear();
  translation_.clear();
  entries_.clear();
}

void ConstraintRows::beginRow() {
  start_.push_back(static_cast<int>(entries_.size()));
  translation_.push_back(Vec3::Zero());
}

void ConstraintRows::add(int mesh_node, const Vec3& derivative) {
  translation_.back() += derivative;
  const int node = model_->freeIndex(mesh_node);
  if (node >= 0) entries_.push_back({node, derivative});
}

void ConstraintRows::add(const EmbeddedPoint& point, const Vec3& derivative) {
  for (int i = 0; i < 4; ++i) add(point.nodes[i], point.weights[i] * derivative);
}

double ConstraintRows::dot(int row, const VecX& x) const {
  double sum = 0;
  for (int k = start_[row]; k < end(row); ++k) sum += entries_[k].derivative.dot(x.segment<3>(3 * entries_[k].node));
  return sum;
}

void ConstraintRows::addTransposed(int row, double factor, VecX& force) const {
  for (int k = start_[row]; k < end(row); ++k) {
    force.segment<3>(3 * entries_[k].node) += factor * entries_[k].derivative;
  }
}

Vec3 calcPosition(const EmbeddedPoint& point, const std::vector<Vec3>& positions) {
  Vec3 position = Vec3::Zero();
  for (int i = 0; i < 4; ++i) position += point.weights[i] * positions[point.nodes[i]];
  return position;
}

}  // namespace sinew
