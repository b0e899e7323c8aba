#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/fem/fem_model.h"
#include "sinew/linalg/block_rows.h"
#include "sinew/mesh/embedding.h"

namespace sinew {

/// The rows of H, each a sparse row over the free nodes. Capacity fixed at set-up.
class ConstraintRows {
 public:
  ConstraintRows(const FemModel& model, int max_rows, int max_entries);

  void clear();
  void beginRow();
  /// Adds d(row) / d(node) to the last row; a fixed node has no column.
  void add(int mesh_node, const Vec3& derivative);
  void add(const EmbeddedPoint& point, const Vec3& derivative);

  int rows() const { return blocks_.rows(); }
  const BlockRows& blocks() const { return blocks_; }
  double dot(int row, const VecX& x) const;                       ///< (H x)_row
  void addTransposed(int row, double factor, VecX& force) const;  ///< force += factor H_row^T
  /// d(row) / d(translation of the whole body), fixed nodes included.
  const Vec3& translation(int row) const { return translation_[row]; }

 private:
  const FemModel* model_;
  BlockRows blocks_;
  std::vector<Vec3> translation_;
};

/// Present position of an embedded point [m].
Vec3 calcPosition(const EmbeddedPoint& point, const std::vector<Vec3>& positions);

}  // namespace sinew
