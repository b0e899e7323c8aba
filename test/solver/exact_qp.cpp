#include "solver/exact_qp.h"

#include <CGAL/Gmpzf.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>
#include <CGAL/QP_solution.h>

#include <cmath>

namespace sinew {

namespace {

using Program = CGAL::Quadratic_program<double>;

void addRow(const QpProblem& problem, int row, CGAL::Comparison_result relation, double limit, int& count,
            Program& program) {
  for (int i = 0; i < problem.variables; ++i) program.set_a(i, count, problem.C(row, i));
  program.set_b(count, limit);
  program.set_r(count, relation);
  ++count;
}

Program makeProgram(const QpProblem& problem) {
  Program program(CGAL::EQUAL, false, 0, false, 0);
  for (int i = 0; i < problem.variables; ++i) {
    program.set_c(i, problem.g(i));
    for (int j = 0; j <= i; ++j) program.set_d(i, j, problem.G(i, j));
    program.set_l(i, std::isfinite(problem.lower(i)), problem.lower(i));
    program.set_u(i, std::isfinite(problem.upper(i)), problem.upper(i));
  }
  int count = 0;
  for (int j = 0; j < problem.rows; ++j) {
    const double lower = problem.row_lower(j);
    const double upper = problem.row_upper(j);
    if (lower == upper) {
      addRow(problem, j, CGAL::EQUAL, lower, count, program);
      continue;
    }
    if (std::isfinite(lower)) addRow(problem, j, CGAL::LARGER, lower, count, program);
    if (std::isfinite(upper)) addRow(problem, j, CGAL::SMALLER, upper, count, program);
  }
  return program;
}

}  // namespace

ExactAnswer solveExactly(const QpProblem& problem) {
  const Program program = makeProgram(problem);  // the solution refers to it
  CGAL::Quadratic_program_options options;
  options.set_pricing_strategy(CGAL::QP_BLAND);
  const auto solution = CGAL::solve_quadratic_program(program, CGAL::Gmpzf(), options);
  if (solution.is_infeasible()) return {QpStatus::kInfeasible, 0};
  if (solution.is_unbounded()) return {QpStatus::kUnbounded, 0};
  return {QpStatus::kSolved, CGAL::to_double(solution.objective_value())};
}

}  // namespace sinew
