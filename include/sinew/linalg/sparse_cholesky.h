#pragma once

#include <memory>

#include "sinew/common/types.h"
#include "sinew/linalg/block_matrix.h"

namespace sinew {

/// A = P^T L L^T P of a symmetric positive definite block matrix: ordered and analysed once, factorised every cycle.
/// Right-hand sides are solved by halves, since W = H A^-1 H^T = Y^T Y needs only Y = L^-1 P H^T.
class SparseCholesky {
 public:
  explicit SparseCholesky(const BlockPattern& pattern);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  int size() const;
  /// False when the matrix is not positive definite; nothing may be solved then.
  bool factorise(const BlockMatrix& matrix);

  /// Place of degree of freedom `i` in the permuted order of `forwardSolve`.
  int permuted(int i) const;
  /// columns <- L^-1 columns, for `count` leading columns given in permuted order [size x >= count].
  void forwardSolve(MatX& columns, int count);
  /// x <- P^T L^-T y: ends the solve of a right-hand side halved by `forwardSolve`.
  void backwardSolve(const VecX& y, VecX& x);
  /// x <- A^-1 x, in natural order.
  void solve(VecX& x);

  double factorNonZeros() const;
  bool supernodal() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
