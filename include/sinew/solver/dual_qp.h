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
/// J^T G J = I, J^T N = [R; 0], N being the active normals. Nothing allocates after construction.
class DualQp {
 public:
  enum class Outcome { kOptimal, kInfeasible, kCutOff, kInterrupted, kFailed };

  DualQp(int max_unknowns, int max_rows, InstructionSet set = chooseInstructionSet());

  /// Starts from the unconstrained minimiser. False if G is not safely positive definite, or if interrupted.
  bool start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, QpInterruption* interruption = nullptr);
  /// The same from the minimiser with some unknowns at 0, their lower limit: those `held` [per unknown] that want to go
  /// below it. `rows` is what `minimise` will be given.
  bool start(const Eigen::Ref<const MatX>& G, const Eigen::Ref<const VecX>& g, int rows, const std::vector<char>& held,
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

  int activeCount() const { return count_; }
  /// A row, or rows + an unknown.
  int activeLimit(int position) const { return limit_[static_cast<std::size_t>(position)]; }
  bool activeAtLower(int position) const { return sign_(position) > 0; }
  /// >= 0, but for equalities.
  double activeDual(int position) const { return dual_(position); }

 private:
  struct Violation {
    int limit = -1;
    double sign = 0;  ///< +1 below the lower limit, -1 above the upper one
    double amount = 0;
  };

  bool factorise(const Eigen::Ref<const MatX>& G, QpInterruption* interruption);
  void invert(int held);
  void release(const Eigen::Ref<const VecX>& g);
  void updateValues(const QpRows& rows);
  Violation findViolation(const QpRows& rows, const QpLimits& limits);
  double calcTolerance(const QpRows& rows, int limit) const;
  void project(const QpRows& rows, const Violation& violation);
  Outcome enforce(const QpRows& rows, const QpLimits& limits, Violation violation, double cutoff);
  void calcDirections();
  int findBlocking(double& length) const;
  void append(int limit, double sign, double dual, bool fixed);
  void remove(int position);

  int stride() const { return static_cast<int>(J_.outerStride()); }

  const DenseKernels* kernels_;
  int unknowns_ = 0, rows_ = 0, count_ = 0, steps_ = 0;
  double value_ = 0;
  MatX J_, R_;
  VecX x_, dual_, sign_;
  std::vector<int> limit_;
  std::vector<char> fixed_;  ///< active equalities, by position
  std::vector<int> order_;   ///< unknowns, those held at the start first

  VecX values_, misses_;
  VecX projected_, direction_, dual_direction_;  ///< J^T n, J2 J2^T n, R^-1 J1^T n of the normal n
  double free_curvature_ = 0;                    ///< |J2^T n|^2
};

}  // namespace sinew
