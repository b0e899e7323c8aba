#include "sinew/inverse/forward_problem.h"

#include <limits>

namespace sinew {

ForwardProblem::ForwardProblem(const VecX& effort_min)
    : effort_min_(effort_min),
      scale_(effort_min.size()),
      problem_(static_cast<int>(effort_min.size()), 0),
      solution_(static_cast<int>(effort_min.size()), 0),
      qp_(static_cast<int>(effort_min.size()), 0) {}

QpStatus ForwardProblem::solve(const MatX& W, const VecX& displacement, const VecX& effort, const Actuation& actuation,
                               VecX& effort_change) {
  const int n = static_cast<int>(effort_min_.size());
  scale_ = W.diagonal().head(n).cwiseSqrt();
  if (!(scale_.minCoeff() > 0)) return QpStatus::kNotFinite;
  problem_.resize(n, 0);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) problem_.G(i, j) = W(i, j) / (scale_[i] * scale_[j]);
    const bool held = actuation.mode[i] == Actuation::Mode::kDisplacement;
    const double change = held ? effort_min_[i] - effort[i] : actuation.value[i] - effort[i];
    problem_.lower[i] = change * scale_[i];
    problem_.upper[i] = held ? std::numeric_limits<double>::infinity() : problem_.lower[i];
    problem_.g[i] = (held ? displacement[i] - actuation.value[i] : displacement[i]) / scale_[i];
  }
  const QpStatus status = qp_.solve(problem_, solution_);
  if (status == QpStatus::kSolved) effort_change = solution_.x.head(n).cwiseQuotient(scale_);
  return status;
}

}  // namespace sinew
