#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// A convex quadratic program
///   minimise 1/2 x^T G x + g^T x   subject to   lower <= x <= upper,   row_lower <= C x <= row_upper.
/// G is symmetric positive semi-definite, down to G = 0 (a linear program). An infinite limit is none, equal limits
/// make an equality. Unknowns and rows may have any units, which may differ from entry to entry.
struct QpProblem {
  /// Allocates for at most these sizes; starts with all of them: no objective, no limits.
  QpProblem(int max_variables, int max_rows);

  /// Changes the sizes within the capacity and never allocates. The entries keep their old values.
  void resize(int new_variables, int new_rows);

  int variables = 0;
  int rows = 0;
  MatX G;                     ///< the leading variables x variables block counts, both triangles filled
  VecX g, lower, upper;       ///< the leading `variables` entries count
  MatX C;                     ///< the leading rows x variables block counts
  VecX row_lower, row_upper;  ///< the leading `rows` entries count
};

enum class QpStatus {
  kSolved,          ///< `x` and the duals satisfy the optimality conditions
  kInfeasible,      ///< no x satisfies the limits; the duals prove it
  kUnbounded,       ///< the objective falls for ever; `x` is a direction along which it does
  kIterationLimit,  ///< the iterations ran out, or the accuracy was not reached
  kNotFinite        ///< the problem holds a NaN, an infinite coefficient, a lower limit of +inf or an upper one of -inf
};

/// Answer of a QP. A positive dual belongs to a lower limit, a negative one to an upper limit, zero to neither.
///
/// Solved:      G x + g = bound_dual + C^T row_dual, and a dual is non-zero only where its limit is reached.
/// Infeasible:  C^T row_dual + bound_dual = 0 while the sum of dual * limit over all bounds and rows is positive, with
/// the
///              limit that the dual's sign names (Farkas: every feasible x would make that sum <= 0). Limits that
///              cross, lower > upper, are a proof of their own: all duals are then zero.
/// Unbounded:   x is a direction, largest entry 1: G x = 0, g^T x < 0, and no limit is ever met along it.
/// Otherwise:   nothing here may be used.
struct QpSolution {
  QpSolution(int max_variables, int max_rows);

  QpStatus status = QpStatus::kIterationLimit;
  VecX x;           ///< leading `variables` entries
  VecX bound_dual;  ///< leading `variables` entries, unit of the objective per unit of x
  VecX row_dual;    ///< leading `rows` entries, unit of the objective per unit of the row
  double objective = 0;
  double residual = 0;  ///< worst KKT violation of a solved problem, relative, see `KktResidual`
  int iterations = 0;   ///< changes of the active set, not counting those of the warm start
  int passes = 0;       ///< proximal passes; 1 where G is positive definite
};

}  // namespace sinew
