#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// Orthonormal basis of the row space of a small matrix, by Gram-Schmidt with pivoting and one reorthogonalisation.
class RowSpace {
 public:
  RowSpace(int max_rows, int columns);

  /// Of the leading `rows` rows of `matrix`; what remains of a row below `tolerance` of the longest one adds nothing.
  void update(const MatX& matrix, int rows, double tolerance);

  int rank() const { return rank_; }
  const MatX& basis() const { return basis_; }  ///< leading `rank()` rows are orthonormal

 private:
  void removeBasis(int row);

  MatX remainder_;
  MatX basis_;
  int rank_ = 0;
};

}  // namespace sinew
