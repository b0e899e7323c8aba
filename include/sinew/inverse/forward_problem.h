#pragma once

#include "sinew/common/types.h"
#include "sinew/inverse/actuation.h"
#include "sinew/solver/dense_qp.h"

namespace sinew {

/// Efforts and contact forces of a given actuation at the linearised robot (thesis 4.3.1). A cable reeled in by u obeys
///   0 <= effort - effort_min  _|_  displacement - u >= 0:
/// it is taut at that length, or slack; a contact obeys Signorini's law,
///   0 <= force  _|_  gap >= 0.
/// With W positive semi-definite both together are the QP
///   min 1/2 f^T W f + f^T (displacement - u, gap),   change >= effort_min - effort,  force >= 0,
/// f being the changes of effort and the contact forces, in which given efforts are fixed unknowns. No allocation after
/// construction.
class ForwardProblem {
 public:
  ForwardProblem(const VecX& effort_min, int max_contacts);

  using Vector = Eigen::Ref<const VecX>;

  /// `W` [m/N] has the actuators' rows leading and the contacts' from `first_contact` on; `displacement` and `gap` [m]
  /// are those with efforts unchanged and no contact force; `effort` [N] is the present total.
  QpStatus solve(const Eigen::Ref<const MatX>& W, int first_contact, const Vector& displacement, const Vector& gap,
                 const VecX& effort, const Actuation& actuation);

  auto effortChange() const { return change_.head(actuators_); }                ///< N
  auto contactForce() const { return change_.segment(actuators_, contacts_); }  ///< N
  int iterations() const { return solution_.iterations; }

 private:
  bool scale(const Eigen::Ref<const MatX>& W, int first_contact);

  VecX effort_min_, scale_, change_;
  int actuators_, contacts_ = 0;
  QpProblem problem_;
  QpSolution solution_;
  DenseQp qp_;
};

}  // namespace sinew
