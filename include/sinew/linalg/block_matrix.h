#pragma once

#include <vector>

#include "sinew/common/aligned_vector.h"
#include "sinew/common/types.h"

namespace sinew {

/// Where one 3x3 block lives in the values of a BlockMatrix: entry (r, c) at `first + c * stride + r`.
struct BlockSlot {
  int first = -1;
  int stride = 0;
};

/// Lower-triangular sparsity of a symmetric matrix of 3x3 blocks, one block row per free node. A block column is stored
/// as one dense column-major panel, three scalar columns wide, its diagonal block on top; read as scalar columns it is
/// an ordinary compressed-column matrix whose diagonal blocks hold both triangles.
class BlockPattern {
 public:
  /// Every pair of nodes within a clique is coupled; negative entries (fixed nodes) are passed over.
  BlockPattern(int blocks, const std::vector<std::vector<int>>& cliques);

  /// The same matrix with block order[k] as its k-th, in compressed columns.
  BlockPattern renumbered(const std::vector<int>& order) const;

  int blocks() const { return static_cast<int>(column_start_.size()) - 1; }
  int size() const { return 3 * blocks(); }
  int blockCount() const { return static_cast<int>(row_.size()); }
  /// Slot of block (row, column), row >= column. The pair must be in the pattern.
  BlockSlot slot(int row, int column) const;
  const std::vector<int>& columnStart() const { return column_start_; }
  const std::vector<int>& rows() const { return row_; }

 private:
  std::vector<int> column_start_;  // blocks + 1, into row_
  std::vector<int> row_;           // block rows, ascending within a column, diagonal first
};

/// Values over a BlockPattern, which must outlive it.
class BlockMatrix {
 public:
  explicit BlockMatrix(const BlockPattern& pattern);

  const BlockPattern& pattern() const { return *pattern_; }
  AlignedVector<double>& values() { return values_; }
  const AlignedVector<double>& values() const { return values_; }
  void setZero();
  void scale(double factor);
  /// Diagonal blocks also take their upper triangle.
  void add(const BlockSlot& slot, const Mat3& block) {
    double* value = values_.data() + slot.first;
    for (int c = 0; c < 3; ++c, value += slot.stride) {
      for (int r = 0; r < 3; ++r) value[r] += block(r, c);
    }
  }
  /// y += factor * A x with the whole symmetric matrix.
  void addProduct(double factor, const VecX& x, VecX& y) const;
  MatX makeDense() const;

 private:
  const BlockPattern* pattern_;
  AlignedVector<double> values_;
};

}  // namespace sinew
