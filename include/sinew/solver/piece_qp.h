#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/complementarity_tableau.h"
#include "sinew/solver/dual_qp.h"
#include "sinew/solver/scaled_qpcc.h"

namespace sinew {

/// How good a point is, first things first; in scaled units.
struct PieceMerit {
  double row_violation = 0;
  double soft_violation = 0;  ///< as a share of `ScaledQpcc::soft_range`, the largest one
  double objective = 0;

  bool feasible() const { return row_violation == 0 && soft_violation == 0; }
};

/// Whether a is better than b by more than rounding.
bool isBetter(const PieceMerit& a, const PieceMerit& b);

struct PieceAnswer {
  explicit PieceAnswer(const QpccSizes& capacity);

  bool valid = false;
  PieceMerit merit;
  VecX x;
  VecX row;                     ///< value of the rows behind the contacts': limited ones, effectors
  std::vector<int> candidates;  ///< contacts whose change of sides lets the answer improve, the most promising first
};

/// The QP of one complementarity choice, in the n_a unknowns x: the contact forces follow from `map`, columns of a
/// ComplementarityTableau. Where nothing satisfies all limits, they give way by the least largest violation: first that
/// of the limited rows, then that of the soft limits. Nothing allocates after construction.
class PieceQp {
 public:
  explicit PieceQp(const QpccSizes& capacity);

  /// `problem` must outlive the calls below.
  void attach(const ScaledQpcc& problem);

  /// Within all limits; false if there is no such point.
  bool solve(const Eigen::Ref<const MatX>& map, PieceAnswer& answer);

  /// The same, limits giving way as needed; false if the piece is empty even so.
  bool solveElastic(const Eigen::Ref<const MatX>& map, PieceAnswer& answer);

  /// Solves again near the last solution, without the ridge that makes flat objectives strictly convex; `merit` is that
  /// of the last solution. Returns x in `answer`.
  bool polish(const Eigen::Ref<const MatX>& map, const PieceMerit& merit, PieceAnswer& answer);

 private:
  struct Candidate {
    int contact;
    double dual;
  };

  void updateObjective(const Eigen::Ref<const MatX>& map);
  void updateLimits(const PieceMerit& relaxation);
  bool minimise(const Eigen::Ref<const MatX>& map, PieceAnswer& answer);
  bool minimiseSoftViolation(const Eigen::Ref<const MatX>& map, PieceMerit& merit);
  bool minimiseRowViolation(const Eigen::Ref<const MatX>& map, PieceMerit& merit);
  bool minimiseViolation(int rows, double& violation);
  bool conclude(PieceAnswer& answer);
  void collectCandidates(const DualQp& qp);
  double calcObjective(const Eigen::Ref<const MatX>& map, const Eigen::Ref<const VecX>& x) const;

  const ScaledQpcc* problem_ = nullptr;
  DualQp qp_, elastic_qp_;
  QpLimits limits_, elastic_limits_;
  MatX G_, elastic_G_, elastic_map_;
  VecX g_, shifted_, elastic_g_;
  double ridge_ = 0;
  std::vector<Candidate> candidates_;
};

}  // namespace sinew
