#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/fem/fem_model.h"
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

  int rows() const { return static_cast<int>(start_.size()); }
  double dot(int row, const VecX& x) const;                       ///< (H x)_row
  void addTransposed(int row, double factor, VecX& force) const;  ///< force += factor H_row^T
  /// d(row) / d(translation of the whole body), fixed nodes included.
  const Vec3& translation(int row) const { return translation_[row]; }
  /// Writes H_row^T into `column` of length model.size(), each degree of freedom i at place[i].
  template <typename Place>
  void scatter(int row, const Place& place, double* column) const {
    for (int k = start_[row]; k < end(row); ++k) {
      for (int c = 0; c < 3; ++c) column[place(3 * entries_[k].node + c)] += entries_[k].derivative[c];
    }
  }

 private:
  struct Entry {
    int node;  // free index
    Vec3 derivative;
  };
  int end(int row) const { return row + 1 < rows() ? start_[row + 1] : static_cast<int>(entries_.size()); }

  const FemModel* model_;
  std::vector<int> start_;
  std::vector<Vec3> translation_;
  std::vector<Entry> entries_;
};

/// Present position of an embedded point [m].
Vec3 calcPosition(const EmbeddedPoint& point, const std::vector<Vec3>& positions);

}  // namespace sinew
