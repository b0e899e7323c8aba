#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/inverse/actuation.h"
#include "sinew/solver/complementarity_gauss_seidel.h"
#include "sinew/solver/dense_qp.h"

namespace sinew {

/// Efforts and contact forces of a given actuation at the linearised robot (thesis 4.3.1). A cable reeled in by u obeys
///   0 <= effort - effort_min  _|_  displacement - u >= 0:
/// it is taut at that length, or slack (a carrier, without effort_min, is where it was driven to); a contact obeys
/// Signorini's law,
///   0 <= force  _|_  gap >= 0.
/// Given efforts are no unknowns. Block Gauss-Seidel solves it, the actuators being one block; where that does not end,
/// the QP that is equivalent since W is positive semi-definite,
///   min 1/2 f^T W f + f^T (displacement - u, gap),   change >= effort_min - effort,  force >= 0.
/// No allocation after construction.
class ForwardProblem {
 public:
  ForwardProblem(const VecX& effort_min, int max_contacts);

  const VecX& effortMin() const { return effort_min_; }  ///< N

  using Vector = Eigen::Ref<const VecX>;

  /// `W` [m/N] has the actuators' rows leading and the contacts' from `first_contact` on; `displacement` and `gap` [m]
  /// are those with efforts unchanged and no contact force; `effort` [N] is the present total; `guess` [N] are contact
  /// forces to start from.
  QpStatus solve(const Eigen::Ref<const MatX>& W, int first_contact, const Vector& displacement, const Vector& gap,
                 const VecX& effort, const Actuation& actuation, const Vector& guess);

  auto effortChange() const { return change_.head(actuators_); }                ///< N
  auto contactForce() const { return change_.segment(actuators_, contacts_); }  ///< N
  auto contactGap() const { return gap_.head(contacts_); }                      ///< m, at the solution
  int iterations() const { return iterations_; }  ///< sets of taut cables and pressing contacts that were tried

 private:
  bool gatherRows(const Eigen::Ref<const MatX>& W, int first_contact, const VecX& effort, const Actuation& actuation);
  void gatherProblem(const Eigen::Ref<const MatX>& W, const Vector& displacement, const Vector& gap,
                     const Actuation& actuation, const Vector& guess);
  QpStatus solveProblem();
  QpStatus solveAsQp();

  VecX effort_min_;
  int actuators_, contacts_ = 0, iterations_ = 0;
  std::vector<int> unknowns_, rows_;  // of the problem's rows: places in change_, rows of W
  VecX scale_, x_;                    // of and in the problem's rows
  VecX change_, gap_;
  ComplementarityProblem problem_;
  ComplementarityGaussSeidel gauss_seidel_;
  QpProblem qp_problem_;
  QpSolution qp_solution_;
  DenseQp qp_;
};

}  // namespace sinew
