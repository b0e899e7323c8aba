#pragma once

#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// A mixed linear complementarity problem,
///   0 <= x_i  _|_  (A x + b)_i >= 0,   and, where `equality`,   (A x + b)_i = 0 with x_i of any sign.
/// A is symmetric positive semi-definite, its rows may depend on each other, and it is scaled: a diagonal of 1, or of 0
/// in a row of zeros.
struct ComplementarityProblem {
  explicit ComplementarityProblem(int max_size);

  int size = 0;
  int block = 0;               ///< so many leading rows are moved together
  MatX A;                      ///< the leading size x size block counts
  VecX b;                      ///< the leading `size` entries count
  std::vector<char> equality;  ///< likewise
};

enum class ComplementarityStatus { kSolved, kNotConverged, kNotFinite };

/// Projected block Gauss-Seidel with an exact end. Sweeps converge linearly at best, but name the rows that press after
/// a few. These are then solved for directly, and rows of a wrong sign exchanged all at once (Judice and Pires, "A
/// block principal pivoting algorithm for large-scale strictly monotone linear complementarity problems", Computers
/// Oper. Res. 21, 1994); where that makes no progress, one by one on a way that descends (Lawson and Hanson, "Solving
/// least squares problems", 1974).
///
/// A diagonal lifted by `kLift` keeps every set of rows solvable, and answers where rows that depend on each other
/// leave none. Where there is an exact answer, the lift is refined away again: signs, and zeros on the side that is to
/// be zero, then hold to rounding. No allocation after construction.
class ComplementarityGaussSeidel {
 public:
  static constexpr double kLift = 1e-9;

  explicit ComplementarityGaussSeidel(int max_size);

  /// `x`: where to start, and the answer of a solved problem; otherwise it stays as it was.
  ComplementarityStatus solve(const ComplementarityProblem& problem, Eigen::Ref<VecX> x);

  auto value() const { return value_.head(size_); }    ///< A x + b at the answer
  int directSolves() const { return direct_solves_; }  ///< of the last problem

 private:
  void start(const ComplementarityProblem& problem, const Eigen::Ref<const VecX>& x);
  void sweep();
  bool moveBlock();
  void moveRow(int i);
  void move(int i, double step);
  bool finishExactly();
  bool exchange();
  bool descend();
  bool stopAtZero();
  void markActive();
  bool solveActive();
  bool refine();
  double calcResidual() const;
  void accept(const VecX& x);
  void updateValue();
  double calcLargest() const;
  bool wrong(int i, double rounding) const;
  int exchangeWrong();
  int findWorst() const;

  const ComplementarityProblem* problem_ = nullptr;
  int size_ = 0, active_count_ = 0, direct_solves_ = 0;
  bool has_block_ = false;
  VecX x_, value_, swept_, lifted_, step_;
  MatX block_factor_, active_factor_;  // Cholesky factors, lower triangles
  std::vector<char> active_;
  std::vector<int> list_;  // of the active rows
};

}  // namespace sinew
