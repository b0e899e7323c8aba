#pragma once

#include <random>

#include "sinew/solver/qp_problem.h"

namespace sinew {

/// Small integers: degenerate, rank-deficient, redundant, and of any status.
QpProblem makeIntegerQp(int variables, int rows, std::mt19937& random);

/// Real numbers, G positive definite or zero on some bounded unknowns, with a point at least 1e-6 within all limits.
QpProblem makeFeasibleQp(int variables, int rows, std::mt19937& random);

/// Real numbers, all unknowns bounded, with rows that contradict each other by at least 1e-3. Needs two rows.
QpProblem makeInfeasibleQp(int variables, int rows, std::mt19937& random);

}  // namespace sinew
