#pragma once

#include "sinew/common/types.h"
#include "sinew/solver/qp_problem.h"

namespace sinew {

/// Units in which a QP is well scaled: x = unknown * x', row = row' / row_scale, objective = objective' /
/// objective_scale. All factors are powers of two, so that scaling rounds nothing.
struct QpScaling {
  QpScaling(int max_variables, int max_rows);

  VecX unknown;          ///< leading `variables` entries: unit of x
  VecX row;              ///< leading `rows` entries: 1 / unit of the row
  double objective = 1;  ///< 1 / unit of the objective
};

/// Brings the diagonal of G and the largest entry of every row and column of C near one. Where G and C disagree about
/// the unit of an unknown, it takes the geometric mean. The problem must be finite. Never allocates.
void updateScaling(const QpProblem& problem, QpScaling& scaling);

/// A QP in scaled units, with bounds and rows in one numbering: constraint k is the bound of unknown k for
/// k < variables, and row k - variables after that.
struct ScaledQp {
  ScaledQp(int max_variables, int max_rows);

  int constraints() const { return variables + rows; }

  int variables = 0;
  int rows = 0;
  MatX G;             ///< leading variables x variables block
  VecX g;             ///< leading `variables` entries
  MatX normals;       ///< leading variables x rows block: C^T
  VecX lower, upper;  ///< leading `constraints()` entries
};

/// Writes `problem` in the units of `scaling`. Limits that cross by rounding only become equal. Never allocates.
void scaleProblem(const QpProblem& problem, const QpScaling& scaling, ScaledQp& scaled);

}  // namespace sinew
