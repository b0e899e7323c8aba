#pragma once

#include "sinew/solver/qp_problem.h"

namespace sinew {

struct ExactAnswer {
  QpStatus status = QpStatus::kIterationLimit;
  double objective = 0;  ///< when solved
};

/// Solves a QP in exact arithmetic (CGAL), taking its doubles for the exact data. The oracle of the solver tests.
ExactAnswer solveExactly(const QpProblem& problem);

}  // namespace sinew
