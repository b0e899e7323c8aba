#pragma once

#include <memory>

#include "sinew/linalg/sparse_cholesky.h"

namespace sinew {

/// SparseCholesky by CHOLMOD and BLAS.
class CholmodCholesky : public SparseCholesky {
 public:
  CholmodCholesky(const FactorPattern& pattern, int max_rows);
  ~CholmodCholesky() override;
  CholmodCholesky(const CholmodCholesky&) = delete;
  CholmodCholesky& operator=(const CholmodCholesky&) = delete;

  int size() const override;
  bool factorise(const BlockMatrix& matrix) override;
  void condense(const BlockRows& H, const VecX& load, Eigen::Ref<MatX> compliance, Eigen::Ref<VecX> motion) override;
  void calcMotion(const VecX& force, VecX& x) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
