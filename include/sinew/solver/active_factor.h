#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// Factors of the equality-constrained QP of an active set, updated in O(n^2) when a constraint comes or goes:
///   J^T (G + P) J = I,   J^T N = [R; 0],   the columns of N being the active normals, R upper triangular.
/// P is diagonal, zero except where G alone has no usable pivot.
/// Goldfarb and Idnani, "A numerically stable dual method for solving strictly convex quadratic programs", Math. Prog.
/// 27 (1983). Nothing allocates after construction.
class ActiveFactor {
 public:
  explicit ActiveFactor(int max_variables);

  /// Factorises G, with no active constraint. Pivots that vanish against the diagonal of G are lifted to `lift`.
  void reset(const Eigen::Ref<const MatX>& G, double lift);

  int variables() const { return variables_; }
  int size() const { return size_; }
  bool lifted() const { return lifted_; }

  /// Diagonal of P, `variables()` entries.
  auto proximal() const { return proximal_.head(variables_); }

  /// Expresses a normal in the basis J, for the calls below: a general one, or the unit vector of an unknown.
  void project(const Eigen::Ref<const VecX>& normal);
  void project(int unknown);

  /// Whether the projected normal is a combination of the active ones, up to `tolerance`.
  bool dependent(double tolerance) const;

  /// n^T z of the projected normal n and its primal direction z.
  double curvature() const { return free().squaredNorm(); }

  /// Steepest direction for the projected normal that keeps the active values: z = J2 J2^T n.
  void calcPrimalDirection(Eigen::Ref<VecX> z) const;

  /// Coefficients of the projected normal in the active ones, `size()` entries: R r = J1^T n.
  void calcDualDirection(Eigen::Ref<VecX> r) const;

  /// Makes the projected normal the last active one; it must not be dependent.
  void append();

  /// Takes out the active normal at `position`; those behind it move up.
  void remove(int position);

  /// Solves (G + P) dx - N du = dual_residual, N^T dx = primal_residual.
  void solve(const Eigen::Ref<const VecX>& dual_residual, const Eigen::Ref<const VecX>& primal_residual,
             Eigen::Ref<VecX> dx, Eigen::Ref<VecX> du);

 private:
  Eigen::VectorBlock<const VecX> fixed() const { return projected_.head(size_); }
  Eigen::VectorBlock<const VecX> free() const { return projected_.segment(size_, variables_ - size_); }

  int variables_ = 0;
  int size_ = 0;
  bool lifted_ = false;
  MatX J_, R_;
  MatX cholesky_;  ///< upper triangle U, G + P = U^T U
  VecX proximal_, projected_, work_;
};

}  // namespace sinew
