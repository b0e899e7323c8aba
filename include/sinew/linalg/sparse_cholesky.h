#pragma once

#include <memory>

#include "sinew/common/cholesky_method.h"
#include "sinew/common/types.h"
#include "sinew/linalg/block_rows.h"
#include "sinew/linalg/factor_pattern.h"

namespace sinew {

/// A = L L^T of a symmetric positive definite block matrix: analysed once, factorised every cycle, and what a control
/// cycle asks of the factor: the compliance of a few sparse rows, and the motion that forces on them cause.
class SparseCholesky {
 public:
  virtual ~SparseCholesky() = default;

  virtual int size() const = 0;
  /// False when the matrix is not positive definite; nothing may be solved then. The values are spent: a factor may
  /// take their place.
  virtual bool factorise(const BlockMatrix& matrix) = 0;
  /// compliance = H A^-1 H^T [rows x rows] and motion = H A^-1 load [rows], from one forward substitution.
  virtual void condense(const BlockRows& H, const VecX& load, Eigen::Ref<MatX> compliance, Eigen::Ref<VecX> motion) = 0;
  /// x = A^-1 (load + H^T force) for H and load of the last `condense`, by one backward substitution.
  virtual void calcMotion(const VecX& force, VecX& x) = 0;

  /// x <- A^-1 x, in place of the last `condense`.
  void solve(VecX& x);
};

/// For at most `max_rows` rows of H, with `threads` counting the caller's (CHOLMOD takes one). Throws ConfigError where
/// the build has no such method.
std::unique_ptr<SparseCholesky> makeSparseCholesky(CholeskyMethod method, const FactorPattern& pattern, int max_rows,
                                                   int threads = 1);

}  // namespace sinew
