#pragma once

#include "sinew/common/types.h"
#include "sinew/inverse/row_space.h"
#include "sinew/solver/dense_qp.h"

namespace sinew {

constexpr double kHoldWeight = 256;  ///< of a row that is to hold and cannot, against the other effector rows

/// One cycle's limits, already intersected with what the rates allow; one entry per actuator.
struct CycleLimits {
  explicit CycleLimits(int actuators);
  VecX displacement_min, displacement_max;  ///< m; never give way
  VecX effort_min, effort_max;              ///< N, of the total effort; give way when nothing else is possible
};

/// The linear problem of one cycle (thesis 3.3.2), in increments of the efforts d. Where contacts press, their forces
/// have been eliminated from it, see `ContactPiece`.
struct InverseProblemData {
  InverseProblemData(int actuators, int max_effector_rows, int max_contacts);
  VecX unit_compliance;  ///< actuators, m/N > 0: W_aa's diagonal without contacts, the scale of the unknowns
  MatX W_aa;             ///< actuators x actuators, m/N
  MatX W_ea;             ///< effector rows x actuators, m/N; the leading `effector_rows` count
  VecX effector_error;   ///< weighted error with efforts unchanged, m
  int effector_rows = 0;
  int held_rows = 0;   ///< the leading ones are to hold
  bool firm = true;    ///< these are equalities; otherwise, and where that is impossible, they weigh `kHoldWeight`
  VecX displacement;   ///< with efforts unchanged, m
  VecX effort;         ///< present total, N
  MatX W_ca;           ///< the leading `contacts` rows count: W_ca d + contact >= -slack, never gives way
  VecX contact;        ///< gaps [m] or forces [N] with efforts unchanged
  VecX contact_slack;  ///< what rounding left of them at a point known to be possible
  int contacts = 0;
  double damping = 0;          ///< 1, against the change of effort, relative to the best-driven direction
  double negligible_gain = 0;  ///< m; when the effector error cannot fall by more, it is left as it is
};

struct InverseProblemResult {
  explicit InverseProblemResult(int actuators);
  QpStatus status = QpStatus::kIterationLimit;
  VecX effort_change;     ///< N
  VecX effort_violation;  ///< N by which an effort limit had to give way, 0 when kept
  bool held = true;       ///< the rows that are to hold were equalities
  int iterations = 0;
};

/// Solves the inverse problem on two levels: least effector error, then, among its minimisers, least potential energy
/// 1/2 effort^T W_aa effort of the total effort (the second-order model of the energy stored by the actuators, whose
/// stationary points it shares). Rows that are to hold are equalities where that is possible. Unknowns are scaled to z
/// = sqrt(W_ii) d_effort, rows likewise, so that every entry of the problem is of order one. When displacement and
/// effort limits exclude each other, the effort limits give way by the least violation. No allocation after
/// construction.
class InverseProblem {
 public:
  InverseProblem(int actuators, int max_effector_rows, int max_contacts);
  QpStatus solve(const InverseProblemData& data, const CycleLimits& limits, InverseProblemResult& result);
  void forget();

 private:
  void scale(const InverseProblemData& data, const CycleLimits& limits);
  bool negligible(const InverseProblemData& data) const;
  QpStatus solveEffectors(const InverseProblemData& data, InverseProblemResult& result);
  void fillEffectors(const InverseProblemData& data, QpProblem& qp);
  QpStatus relaxEfforts(InverseProblemResult& result);
  void solveEnergy(const InverseProblemData& data, InverseProblemResult& result);
  /// Limits on displacements and contacts: the leading rows of every programme in `variables` >= actuators unknowns.
  void fillRows(int variables, QpProblem& qp) const;

  int actuators_, contacts_ = 0, equalities_ = 0;
  VecX scale_;           // sqrt(W_ii)
  MatX W_, E_, C_;       // scaled compliance; scaled effector rows over their largest entry; contact rows, longest 1
  VecX contact_min_;     // of the contact rows
  double unit_ = 1;      // what the effector rows were divided by
  VecX error_, energy_;  // scaled error; scaled gradient of the energy
  VecX z_min_, z_max_, row_min_, row_max_, z_, relaxation_;
  RowSpace row_space_;
  QpProblem effector_problem_, elastic_problem_, energy_problem_;
  QpSolution effector_solution_, elastic_solution_, energy_solution_;
  DenseQp effector_qp_, elastic_qp_, energy_qp_;
};

}  // namespace sinew
