#include "sinew/linalg/sparse_cholesky.h"

#include "sinew/common/config_error.h"
#include "sinew/linalg/supernodal_cholesky.h"
#if defined(SINEW_HAS_CHOLMOD)
#include "sinew/linalg/cholmod_cholesky.h"
#endif

namespace sinew {

void SparseCholesky::solve(VecX& x) {
  const BlockRows none(0, 0);
  MatX compliance(0, 0);
  VecX nothing(0);
  condense(none, x, compliance, nothing);
  calcMotion(nothing, x);
}

std::unique_ptr<SparseCholesky> makeSparseCholesky(CholeskyMethod method, const FactorPattern& pattern, int max_rows,
                                                   int threads) {
  if (method == CholeskyMethod::kSupernodal) return std::make_unique<SupernodalCholesky>(pattern, max_rows, threads);
#if defined(SINEW_HAS_CHOLMOD)
  return std::make_unique<CholmodCholesky>(pattern, max_rows);
#else
  throw ConfigError("control/cholesky", "cholmod", "supernodal: this build was made without CHOLMOD");
#endif
}

}  // namespace sinew
