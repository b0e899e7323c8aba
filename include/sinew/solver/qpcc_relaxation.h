#pragma once

#include "sinew/common/types.h"
#include "sinew/solver/dense_kernels.h"
#include "sinew/solver/dual_qp.h"
#include "sinew/solver/scaled_qpcc.h"

namespace sinew {

/// The convex relaxation of a scaled QPCC in (z, x), without complementarity:
///   minimise f(x, z) + rho z^T g(x, z)   subject to z >= 0, g >= 0 and all other limits.
/// The added term is zero on the points of the QPCC and never negative on the others, so that the minimum is a lower
/// bound; rho is the largest for which the sum stays convex. C_c is lifted as in the ComplementarityTableau. Nothing
/// allocates after construction.
class QpccRelaxation {
 public:
  explicit QpccRelaxation(const QpccSizes& capacity, InstructionSet set = chooseInstructionSet());

  /// False if the objective could not be made safely convex, or if interrupted: there is then no bound.
  bool prepare(const ScaledQpcc& problem, QpInterruption* interruption = nullptr);

  /// Starts `qp` at the unconstrained minimiser of the relaxation, or with forces of the contacts `open` [per contact
  /// and unknown] at 0, which is much nearer to its end where most are; false as above.
  bool start(DualQp& qp, const std::vector<char>& open = {}, QpInterruption* interruption = nullptr) const;

  QpRows rows() const;
  /// Of the rows and of (z, x); what branching tightens.
  QpLimits& limits() { return limits_; }
  /// To be added to the QP's value.
  double constant() const { return constant_; }
  /// By how much the QP's value may exceed the lower bound that it stands for; infinite where x is not bounded.
  double calcSlack() const;
  double rho() const { return rho_; }

 private:
  bool updateGrams(QpInterruption* interruption);
  bool isConvex(double rho);
  double findLargestRho();
  bool updateObjective(QpInterruption* interruption);
  void updateLimits();

  const ScaledQpcc* problem_ = nullptr;
  const DenseKernels* kernels_;
  MatX map_;     ///< limited rows x (contacts, unknowns, 1)
  MatX E_;       ///< (z, x) x effectors
  MatX G_;       ///< of (z, x)
  VecX g_;       ///< of (z, x)
  MatX factor_;  ///< L on top, below it X = [C_a E_c^T]^T L^-T, with C_c = L L^T
  VecX row_;     ///< of the factor
  MatX gram_;    ///< X X^T
  MatX K_gram_, F_K_, schur_, small_;
  QpLimits limits_;
  double constant_ = 0, rho_ = 0, ridge_ = 0;
};

}  // namespace sinew
