#pragma once

#include <vector>

#include "sinew/solver/dense_qp.h"
#include "sinew/solver/qpcc_problem.h"

namespace sinew {

/// The plain full formulation: each complementarity choice is a QP in (x, z), all contacts kept, solved by DenseQp.
class FullQpcc {
 public:
  explicit FullQpcc(const QpccProblem& problem);

  /// Least objective of the piece whose active contacts are given; +inf if it is empty. With `soft` false without the
  /// soft limits.
  double solvePiece(const std::vector<char>& active, bool soft = true);

  /// Least objective over all 2^n_c pieces.
  double enumerate(bool soft = true);

  /// Least largest violation of the soft limits, as a share of their ranges, over all pieces; +inf if none is feasible
  /// without them.
  double enumerateSoftViolation();

  /// (x, z) of the last piece with a finite answer.
  const VecX& point() const { return point_; }

 private:
  void setPiece(const std::vector<char>& active, bool soft);

  const QpccProblem& problem_;
  QpProblem qp_;
  QpSolution solution_;
  DenseQp solver_;
  VecX point_;
};

/// What the QPCC asks of (x, z), from its definition, in SI units.
struct QpccResiduals {
  double gap = 0;              ///< most negative gap, m
  double force = 0;            ///< most negative force, relative to the largest one
  double complementarity = 0;  ///< largest |z_i g_i|, relative to the largest z times the largest c
  double limits = 0;           ///< largest miss of a hard limit or row, relative to the largest term
  double objective = 0;        ///< its value
};
QpccResiduals calcResiduals(const QpccProblem& problem, const VecX& x, const VecX& z);

std::vector<char> activeSetOf(unsigned bits, int contacts);

}  // namespace sinew
