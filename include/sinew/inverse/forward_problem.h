#pragma once

#include "sinew/common/types.h"
#include "sinew/inverse/actuation.h"
#include "sinew/solver/dense_qp.h"

namespace sinew {

/// Efforts of a given actuation at the linearised robot (thesis 4.3.1). A cable reeled in by u obeys
///   0 <= effort - effort_min  _|_  displacement - u >= 0:
/// it is taut at that length, or slack. With W positive semi-definite this is the QP
///   min 1/2 d^T W d + d^T (displacement - u),  effort + d >= effort_min,
/// in which given efforts are fixed unknowns. No allocation after construction.
class ForwardProblem {
 public:
  explicit ForwardProblem(const VecX& effort_min);

  /// `W` [m/N] has the actuators' block leading; `displacement` [m] with efforts unchanged; `effort` [N] present total.
  QpStatus solve(const MatX& W, const VecX& displacement, const VecX& effort, const Actuation& actuation,
                 VecX& effort_change);
  int iterations() const { return solution_.iterations; }

 private:
  VecX effort_min_, scale_;
  QpProblem problem_;
  QpSolution solution_;
  DenseQp qp_;
};

}  // namespace sinew
