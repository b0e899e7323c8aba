#pragma once

#include "sinew/common/types.h"
#include "sinew/solver/dual_active_set.h"
#include "sinew/solver/qp_problem.h"
#include "sinew/solver/qp_scaling.h"

namespace sinew {

struct DenseQpSettings {
  int max_iterations = 2000;  ///< changes of the active set
  int max_passes = 100;       ///< proximal passes, for a singular G
  double accuracy = 1e-9;     ///< KKT residual beyond which an answer does not count as solved
};

/// Solves small dense convex QPs, warm-started from its own last active set. The QP is scaled, then solved by the dual
/// active-set method; if G is singular, by proximal passes
///   x_k+1 = argmin f(x) + 1/2 (x - x_k)^T P (x - x_k),   P lifting only the flat directions,
/// each starting from the active set of the last, and from as far along its step as f falls straight. They end after
/// finitely many, at a minimiser of f itself or on a direction along which f is unbounded. Nothing allocates after
/// construction.
class DenseQp {
 public:
  /// Capacity of every QP to come.
  DenseQp(int max_variables, int max_rows, const DenseQpSettings& settings = DenseQpSettings());

  /// Writes all of `solution`, returns its status. The sizes of `problem` must be within the capacity. x satisfies the
  /// bounds to the last bit.
  QpStatus solve(const QpProblem& problem, QpSolution& solution);

  /// The next solve starts cold.
  void forget();

 private:
  QpStatus solveScaled(QpSolution& solution);
  bool passesEnded() const;
  double calcReach();
  void reportPoint(const QpProblem& problem, QpSolution& solution);
  void reportDuals(double factor, QpSolution& solution) const;
  void reportDirection(QpSolution& solution) const;

  DenseQpSettings settings_;
  QpScaling scaling_;
  ScaledQp scaled_;
  DualActiveSet active_set_;
  VecX centre_, step_, last_x_;
  VecX curvature_;
  int last_variables_ = -1;
};

}  // namespace sinew
