#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/active_factor.h"
#include "sinew/solver/qp_scaling.h"

namespace sinew {

/// Minimises 1/2 x^T G x + g^T x + 1/2 (x - centre)^T P (x - centre) under the limits of a scaled QP, by the dual
/// method of Goldfarb and Idnani: x is always the minimiser on the active set with duals of the right sign, and the
/// most violated limit is added until none is left. Every step raises the dual objective, so no active set returns;
/// rounding is kept from undoing that by a tolerance that widens as the iterations go on. Nothing allocates after
/// construction.
class DualActiveSet {
 public:
  DualActiveSet(int max_variables, int max_rows);

  /// Factorises `qp` and activates its equalities, then the active set of the last call if the sizes are the same.
  /// Vanishing pivots of G are lifted to `lift`. `qp` must outlive the calls of `minimise`.
  void start(const ScaledQp& qp, double lift);

  /// The next `start` begins with the equalities only.
  void forget();

  /// Moves on from the present active set. Infeasible: `dual()` is the certificate.
  QpStatus minimise(const Eigen::Ref<const VecX>& centre, int max_iterations);

  auto x() const { return x_.head(qp_->variables); }

  /// One entry a constraint: >= 0 on a lower limit, <= 0 on an upper one, 0 if inactive.
  auto dual() const { return dual_.head(qp_->constraints()); }

  const ActiveFactor& factor() const { return factor_; }

  /// Changes of the active set since `start`.
  int iterations() const { return iterations_; }

 private:
  enum class Side : signed char { kUpper = -1, kNone = 0, kLower = 1, kEquality = 2 };

  struct Violation {
    int constraint = -1;
    double sign = 0;  ///< +1 below the lower limit, -1 above the upper one
    double amount = 0;
  };

  struct Blocking {
    int position = -1;
    double length;
  };

  static double calcSign(Side side) { return static_cast<double>(side); }
  static double calcLargest(const Eigen::Ref<const VecX>& v) { return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0; }

  Side& side(int constraint) { return side_[static_cast<std::size_t>(constraint)]; }
  Side side(int constraint) const { return side_[static_cast<std::size_t>(constraint)]; }
  int& active(int position) { return active_[static_cast<std::size_t>(position)]; }
  int active(int position) const { return active_[static_cast<std::size_t>(position)]; }
  bool isEquality(int constraint) const { return qp_->lower(constraint) == qp_->upper(constraint); }
  double limit(int constraint, double sign) const { return sign > 0 ? qp_->lower(constraint) : qp_->upper(constraint); }

  void activateGuess();
  void activate(int constraint, Side at, double tolerance);
  void append(int constraint, Side at, double dual);
  void remove(int position);
  void project(int constraint);
  double calcValue(int constraint) const;
  void addNormal(int constraint, double factor, VecX& sum) const;

  bool settle();
  void refine();
  int findWrongSign() const;

  Violation findViolation();
  double calcTolerance(int constraint, double sign) const;
  QpStatus enforce(Violation violation, int max_iterations);
  Blocking findBlocking(double sign) const;
  void widenTolerance();

  QpStatus concludeDependent(const Violation& violation);
  bool provesInfeasible(const Violation& violation);
  void calcRemainder(int constraint);
  void scatterDuals();

  ActiveFactor factor_;
  const ScaledQp* qp_ = nullptr;
  int start_variables_ = -1, start_rows_ = -1;  ///< sizes of the last start
  std::vector<Side> side_;                      ///< of every constraint
  std::vector<char> ignored_;                   ///< constraints missed by less than rounding can mend
  std::vector<int> active_;                     ///< constraint at every position of the factor
  VecX active_dual_;                            ///< by position
  VecX x_, dual_, values_, centre_;
  VecX direction_, dual_direction_;
  VecX dual_residual_, primal_residual_, dx_, du_;
  double feasibility_ = 0;  ///< relative tolerance
  double magnitude_ = 0;    ///< of x and of what it came from
  int iterations_ = 0;
};

}  // namespace sinew
