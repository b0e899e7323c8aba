#pragma once

#include <vector>

#include "sinew/common/types.h"

namespace sinew {

struct QpccSizes {
  int unknowns = 0;   ///< n_a, actuator efforts or changes of them
  int rows = 0;       ///< n_r, actuator displacements and other limited rows
  int effectors = 0;  ///< n_e
  int contacts = 0;   ///< n_c
};

/// A quadratic program with complementarity constraints, in the unknowns x and the contact forces z:
///   minimise   1/2 |E_a x + E_c z + e|^2 + 1/2 x^T Q x + q^T x
///   subject to x_lower <= x <= x_upper,   soft_lower <= x <= soft_upper,
///              row_lower <= A_a x + A_c z + a <= row_upper,
///              0 <= z,   g = C_a x + C_c z + c >= 0,   z_i g_i = 0.
/// Q and C_c are symmetric positive semi-definite; duplicate and dependent contacts are allowed. An infinite limit is
/// none, equal limits make an equality. The soft limits give way when nothing else is possible. Every block counts in
/// its leading part; the rest is ignored.
struct QpccProblem {
  /// Allocates for at most `capacity`; starts with all of it: zeros, no limits.
  explicit QpccProblem(const QpccSizes& capacity);

  /// Changes the sizes within the capacity and never allocates. The entries keep their old values.
  void resize(const QpccSizes& sizes);

  QpccSizes size;
  MatX E_a, E_c;                ///< effectors x unknowns, effectors x contacts
  VecX e;                       ///< effector errors at x = 0, z = 0, m
  MatX Q;                       ///< unknowns x unknowns, both triangles filled
  VecX q;                       ///< unknowns
  VecX x_lower, x_upper;        ///< never give way
  VecX soft_lower, soft_upper;  ///< tension and pressure limits
  MatX A_a, A_c;                ///< rows x unknowns, rows x contacts
  VecX a, row_lower, row_upper;
  MatX C_a, C_c;  ///< contacts x unknowns, contacts x contacts
  VecX c;         ///< gaps at x = 0, z = 0, m
};

/// Where the search starts, and what its answer may not be far from.
struct QpccGuess {
  explicit QpccGuess(const QpccSizes& capacity);

  bool valid = false;
  VecX x;
  std::vector<char> active;  ///< 1 where the contact presses
  VecX row;                  ///< A_a x + A_c z + a at the guess
  VecX reach;                ///< greatest |row - guess| of an answer that the decomposition alone does not find
  double margin = 0;         ///< such an answer must stay better when what is asked for changes by this share, 0 to 1
  double offset = 0;         ///< of the objective, which with it is half a square: 1/2 x0^T Q x0 where q = Q x0
};

enum class QpccStatus {
  kSolved,      ///< within all limits
  kGivenWay,    ///< within all but the soft limits, which give way as little as was found possible
  kInfeasible,  ///< no point within the rows and the hard limits of x was found; x misses the rows the least found
  kNotFinite,   ///< the problem holds a NaN, an infinite coefficient, a lower limit of +inf or an upper one of -inf
  kFailed       ///< numerical failure; nothing else here may be used
};

const char* nameOf(QpccStatus status);

/// Answer of a QPCC. Unless not finite or failed, x is within its hard limits to the last bit, and z and g are exactly
/// complementary: of each contact one of the two is zero.
struct QpccSolution {
  explicit QpccSolution(const QpccSizes& capacity);

  QpccStatus status = QpccStatus::kFailed;
  VecX x, z, g;
  std::vector<char> active;  ///< 1 where the contact may press (g = 0), 0 where z = 0
  double objective = 0;

  VecX soft_violation;       ///< per unknown, by how much a soft limit gave way
  double row_violation = 0;  ///< greatest miss of a row

  bool proved_global = false;          ///< no better answer exists, up to 1e-6 of the objective
  double decomposition_objective = 0;  ///< what the first decomposition alone reached; +inf if nothing feasible
  bool declined_better = false;        ///< a better answer was left for being too far or too little better
  double declined_objective = 0;

  int pieces = 0;  ///< QPs solved
  int nodes = 0;   ///< relaxations solved
  bool deadline_ended = false;
};

}  // namespace sinew
