#pragma once

#include <array>

#include "sinew/common/types.h"
#include "sinew/fem/material.h"

namespace sinew {

using TetGradients = Eigen::Matrix<double, 3, 4>;  ///< a column per node

/// A linear tetrahedron at rest.
struct TetShape {
  TetGradients gradients;  ///< of the shape functions in the rest configuration, 1/m
  double volume = 0;       ///< m3
};

TetShape makeTetShape(const std::array<Vec3, 4>& rest);

/// Element quantities in the present configuration.
struct TetLinearisation {
  TetGradients forces;             ///< on the nodes, pulling back to rest, N
  std::array<Mat3, 10> stiffness;  ///< blocks (a, b), a >= b, in the order 00 10 11 20 21 22 30 31 32 33, N/m
};

/// Which derivative of the forces an assembly gives.
enum class Tangent {
  kExact,        ///< the whole of it: Newton converges quadratically, but a body near buckling has it indefinite
  kSemidefinite  ///< without the negative part of the turning of the elements: always usable, linear convergence
};

/// Co-rotational linear elasticity (thesis 3.2.2). With F = sum x_a g_a^T and its rotation R, the stress of the
/// rotated-back strain, sigma = lambda tr(e) I + 2 mu e, e = sym(R^T F) - I, gives the nodal forces -V R sigma g_a. The
/// stiffness is R K_e R^T, written with rotated gradients q = R g:
///   K_ab = V (lambda q_a q_b^T + mu q_b q_a^T + mu (q_a . q_b) I),
/// plus the part of the turning of R, V [q_a]x^T Q [q_b]x with Q = mu I + (lambda tr(e) - 2 mu) G^-1 and
/// G = R (tr(S) I - S) R^T, S = sym(R^T F), which makes it the exact derivative. An element in compression has negative
/// eigenvalues in Q. `R` is the rotation of the last cycle and is updated.
void calcTetForces(const TetShape& shape, const Lame& lame, const TetGradients& positions, Mat3& R,
                   TetGradients& forces);
void calcTetLinearisation(const TetShape& shape, const Lame& lame, const TetGradients& positions, Tangent tangent,
                          Mat3& R, TetLinearisation& result);

}  // namespace sinew
