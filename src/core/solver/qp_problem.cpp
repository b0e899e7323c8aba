#include "sinew/solver/qp_problem.h"

#include <cassert>
#include <limits>

namespace sinew {

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}

QpProblem::QpProblem(int max_variables, int max_rows)
    : variables(max_variables),
      rows(max_rows),
      G(MatX::Zero(max_variables, max_variables)),
      g(VecX::Zero(max_variables)),
      lower(VecX::Constant(max_variables, -kInfinity)),
      upper(VecX::Constant(max_variables, kInfinity)),
      C(MatX::Zero(max_rows, max_variables)),
      row_lower(VecX::Constant(max_rows, -kInfinity)),
      row_upper(VecX::Constant(max_rows, kInfinity)) {}

void QpProblem::resize(int new_variables, int new_rows) {
  assert(0 <= new_variables && new_variables <= g.size());
  assert(0 <= new_rows && new_rows <= row_lower.size());
  variables = new_variables;
  rows = new_rows;
}

QpSolution::QpSolution(int max_variables, int max_rows)
    : x(VecX::Zero(max_variables)), bound_dual(VecX::Zero(max_variables)), row_dual(VecX::Zero(max_rows)) {}

}  // namespace sinew
