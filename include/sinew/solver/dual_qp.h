#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/dense_kernels.h"

namespace sinew {

/// Values y = matrix * x + constant that a QP limits, read in place.
struct QpRows {
  Eigen::Map<const MatX, 0, Eigen::OuterStride<>> matrix;  ///< rows x unknowns
  Eigen::Map<const VecX> constant;                         ///< rows
};

/// The view of the leading rows of a matrix whose last column holds the constants.
template <typename Matrix>
QpRows makeQpRows(const Matrix& map, Eigen::Index rows) {
  const Eigen::Index unknowns = map.cols() - 1;
  return {{map.data(), rows, unknowns, Eigen::OuterStride<>(map.outerStride())},
          {map.data() + unknowns * map.outerStride(), rows}};
}

/// lower <= (y, x) <= upper: the rows first, then the unknowns.
struct QpLimits {
  explicit QpLimits(int capacity) : lower(capacity), upper(capacity) {}
  VecX lower, upper;
};

/// When a minimisation may stop early.
class QpInterruption {
 public:
  virtual ~QpInterruption() = default;
  virtual bool due() = 0;
};

/// Minimises a strictly convex 1/2 x^T G x + g^T x within limits by the dual method of Goldfarb and Idnani (Math. Prog.
/// 27, 1983), for the many small QPs of a search: limits and rows are read in place, the state can be copied, limits
/// can be tightened, and `minimise` goes on from where the last one ended. Everything should be scaled to order one.
/// Unknowns held at a limit of their own are left out of the factors, so that a step costs what the free ones do:
/// J^T G_ff J = I, J^T N_f = [R; 0], N being the normals of the active rows. Nothing allocates after construction.
class DualQp {
 public:
  enum class Outcome { kOptimal, kInfeasible, kCutOff, kInterrupted, kFailed };

  DualQp(int max_unknowns, int max_rows, InstructionSet set = chooseInstructionSet());

  /// Starts from the unconstrained minimiser. False if G is not safely positive definite, or if interrupted. G must
  /// outlive the calls of `minimise`, those of copies too.
  bool start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, QpInterruption* interruption = nullptr);
  /// The same from the minimiser with some unknowns at 0, their lower limit: those `held` [per unknown] that want to go
  /// below it. What G is beyond the others is seen only when they are let go.
  bool start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, const std::vector<char>& held,
             QpInterruption* interruption = nullptr);

  /// Takes over the state of `other`, whose capacity must be the same; costs the size of its QP, not the capacity.
  void copy(const DualQp& other);

  /// Adds violated limits until none is left, or until the value exceeds `cutoff`. Limits that are not
  /// active may have been tightened since the last call; nothing else may have changed.
  Outcome minimise(const QpRows& rows, const QpLimits& limits, double cutoff, QpInterruption* interruption = nullptr);

  /// Moves x onto the active limits, where rounding has left it beside them.
  void settle(const QpRows& rows, const QpLimits& limits);

  int unknowns() const { return unknowns_; }
  auto x() const { return x_.head(unknowns_); }
  /// Of the objective at x: a lower bound of the minimum after any call.
  double value() const { return value_; }
  /// Rows at x, by the last `minimise`.
  auto rowValues() const { return values_.head(rows_); }

  int activeRows() const { return count_; }
  int activeRow(int position) const { return row_[static_cast<std::size_t>(position)]; }
  /// >= 0, but for equalities.
  double rowDual(int position) const { return dual_(position); }

  bool isHeld(int unknown) const { return place_[static_cast<std::size_t>(unknown)] < 0; }
  /// >= 0, but for equalities; 0 unless held.
  double boundDual(int unknown) const { return bound_dual_(unknown); }

 private:
  struct Violation {
    int limit = -1;
    double sign = 0;  ///< +1 below the lower limit, -1 above the upper one
    double amount = 0;
  };
  /// The active limit whose dual is the first to reach zero: a position, or activeRows() + an unknown; -1 without one.
  struct Blocking {
    int limit = -1;
    double length = 0;
  };

  bool factorise(QpInterruption* interruption);
  void invert();
  bool release(const Eigen::Ref<const VecX>& g);
  bool letGo(int unknown);
  void hold(int unknown);
  void updateValues(const QpRows& rows);
  Violation findViolation(const QpRows& rows, const QpLimits& limits);
  double calcTolerance(const QpRows& rows, int limit) const;
  void updateNormal(const QpRows& rows, const Violation& violation);
  void project();
  Outcome enforce(const QpLimits& limits, Violation violation, double cutoff);
  void calcDirections();
  Blocking findBlocking() const;
  bool drop(int blocking);
  void activate(const QpLimits& limits, const Violation& violation, double dual);
  double reflect();
  void append();
  void remove(int position);
  void rotate(int k, int other, double c, double s);

  int stride() const { return static_cast<int>(J_.outerStride()); }
  int unknownAt(int place) const { return unknown_[static_cast<std::size_t>(place)]; }
  template <typename Vector>
  void gatherFree(const Vector& all, VecX& free) const {
    for (int p = 0; p < free_; ++p) free(p) = all(unknownAt(p));
  }

  const DenseKernels* kernels_;
  int unknowns_ = 0, rows_ = 0, steps_ = 0;
  int free_ = 0;   ///< unknowns that are not held
  int count_ = 0;  ///< active rows
  double value_ = 0;
  const double* G_ = nullptr;
  int G_stride_ = 0;
  MatX J_, R_, N_;
  VecX x_;
  std::vector<int> unknown_, place_;  ///< of the free ones by place; the place of each unknown, -1 if held
  VecX side_, bound_dual_;            ///< by unknown: +1 held at its lower limit, -1 at its upper one, 0 free
  std::vector<char> fixed_bound_;     ///< by unknown: held by an equality
  VecX dual_, sign_;                  ///< of the active rows, by position
  std::vector<int> row_;
  std::vector<char> fixed_;

  VecX values_, misses_;
  VecX normal_, projected_;                       ///< n of the limit to be added; J^T n_f
  VecX direction_, dual_direction_, bound_rate_;  ///< J2 J2^T n_f, R^-1 J1^T n_f, what duals of held unknowns lose
  double free_curvature_ = 0;                     ///< |J2^T n_f|^2
  VecX work_, spilled_, pull_;
  std::vector<int> listed_;
};

}  // namespace sinew
