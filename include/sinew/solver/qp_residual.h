#pragma once

#include "sinew/solver/qp_problem.h"
#include "sinew/solver/qp_scaling.h"

namespace sinew {

/// How far (x, bound_dual, row_dual) are from the optimality conditions, in the units of a `QpScaling`: gradients
/// relative to the largest sum of terms of G x + g - bound_dual - C^T row_dual, points relative to the largest entry of
/// x and of g (as G has a unit diagonal, a step along g is of that length). Zero is exact.
struct KktResidual {
  double stationarity = 0;     ///< G x + g - bound_dual - C^T row_dual
  double feasibility = 0;      ///< distance by which a bound or a row is missed
  double complementarity = 0;  ///< the smaller of a dual and of the distance to the limit that its sign names

  double worst() const;
};

/// `scaling` must be that of `problem`. A solution that is not finite gives infinities. Never allocates.
KktResidual calcKktResidual(const QpProblem& problem, const QpScaling& scaling, const QpSolution& solution);

/// What the duals of an infeasible QP prove.
struct InfeasibilityProof {
  double imbalance = 0;  ///< largest entry of bound_dual + C^T row_dual, relative to the terms it is summed from
  double gap = 0;        ///< sum of dual * limit, relative to the sum of the magnitudes; the proof needs > 0

  bool holds(double tolerance) const { return gap > tolerance && imbalance <= tolerance; }
};

/// Crossing limits give a gap of one. A dual that names an infinite limit gives a gap of -infinity. Never allocates.
InfeasibilityProof calcInfeasibilityProof(const QpProblem& problem, const QpScaling& scaling,
                                          const QpSolution& solution);

/// Whether some lower limit exceeds its upper one by more than rounding.
bool hasCrossingLimits(const QpProblem& problem);

}  // namespace sinew
