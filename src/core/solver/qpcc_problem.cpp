#include "sinew/solver/qpcc_problem.h"

#include <cassert>
#include <limits>

namespace sinew {

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}

QpccProblem::QpccProblem(const QpccSizes& capacity)
    : size(capacity),
      E_a(MatX::Zero(capacity.effectors, capacity.unknowns)),
      E_c(MatX::Zero(capacity.effectors, capacity.contacts)),
      e(VecX::Zero(capacity.effectors)),
      Q(MatX::Zero(capacity.unknowns, capacity.unknowns)),
      q(VecX::Zero(capacity.unknowns)),
      x_lower(VecX::Constant(capacity.unknowns, -kInfinity)),
      x_upper(VecX::Constant(capacity.unknowns, kInfinity)),
      soft_lower(VecX::Constant(capacity.unknowns, -kInfinity)),
      soft_upper(VecX::Constant(capacity.unknowns, kInfinity)),
      A_a(MatX::Zero(capacity.rows, capacity.unknowns)),
      A_c(MatX::Zero(capacity.rows, capacity.contacts)),
      a(VecX::Zero(capacity.rows)),
      row_lower(VecX::Constant(capacity.rows, -kInfinity)),
      row_upper(VecX::Constant(capacity.rows, kInfinity)),
      C_a(MatX::Zero(capacity.contacts, capacity.unknowns)),
      C_c(MatX::Zero(capacity.contacts, capacity.contacts)),
      c(VecX::Zero(capacity.contacts)) {}

void QpccProblem::resize(const QpccSizes& sizes) {
  assert(0 <= sizes.unknowns && sizes.unknowns <= q.size());
  assert(0 <= sizes.rows && sizes.rows <= a.size());
  assert(0 <= sizes.effectors && sizes.effectors <= e.size());
  assert(0 <= sizes.contacts && sizes.contacts <= c.size());
  size = sizes;
}

QpccGuess::QpccGuess(const QpccSizes& capacity)
    : x(VecX::Zero(capacity.unknowns)),
      active(static_cast<std::size_t>(capacity.contacts), 0),
      row(VecX::Zero(capacity.rows)),
      reach(VecX::Constant(capacity.rows, kInfinity)) {}

QpccSolution::QpccSolution(const QpccSizes& capacity)
    : x(VecX::Zero(capacity.unknowns)),
      z(VecX::Zero(capacity.contacts)),
      g(VecX::Zero(capacity.contacts)),
      active(static_cast<std::size_t>(capacity.contacts), 0),
      soft_violation(VecX::Zero(capacity.unknowns)) {}

const char* nameOf(QpccStatus status) {
  switch (status) {
    case QpccStatus::kSolved:
      return "solved";
    case QpccStatus::kGivenWay:
      return "given way";
    case QpccStatus::kInfeasible:
      return "infeasible";
    case QpccStatus::kNotFinite:
      return "not finite";
    case QpccStatus::kFailed:
      return "failed";
  }
  return "failed";
}

}  // namespace sinew
