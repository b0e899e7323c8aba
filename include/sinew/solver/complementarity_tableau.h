#pragma once

#include <cstdint>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/dense_kernels.h"
#include "sinew/solver/scaled_qpcc.h"

namespace sinew {

/// The linear maps of a scaled QPCC, solved for the contact forces of its active contacts (principal pivoting): row i
/// of a contact stands for its gap g_i while it is inactive, for its force z_i once it is active; its column for the
/// other one of the two. The other rows keep their meaning. Setting all contact columns to zero,
///   row values = table * (x, 1),
/// are then gaps, forces, limited rows and effector errors of the piece in which each active contact has g_i = 0 and
/// each inactive one z_i = 0. Moving a contact between the sets is one rank-1 update.
///
/// The diagonal of C_c is lifted by `kLift`, which keeps all pivots positive where contacts depend on each other. Its
/// effect is kLift * C_ii z_i, that is 1e-9 of the depth to which the force alone would press: under 1 um for less than
/// 1000 m. Nothing allocates after construction.
class ComplementarityTableau {
 public:
  static constexpr double kLift = 1e-9;

  explicit ComplementarityTableau(const QpccSizes& capacity, InstructionSet set = chooseInstructionSet());

  /// Starts with all contacts inactive. `problem` must outlive the calls below.
  void reset(const ScaledQpcc& problem);

  /// Moves a contact to the other set.
  void pivot(int contact);

  /// Moves contacts until `active` is the active set, from scratch where that takes fewer pivots.
  void moveTo(const std::vector<char>& active);

  /// Swaps what is given and what follows: the unknown's column stands for the limited row, whose row then gives the
  /// unknown. The same call swaps back. Every exchange must be undone before pieces are read.
  void exchange(int row, int unknown);

  bool isActive(int contact) const { return active_[static_cast<std::size_t>(contact)] != 0; }
  const std::vector<char>& active() const { return active_; }
  int activeCount() const { return active_count_; }
  /// Tells active sets apart.
  std::uint64_t hash() const { return hash_; }
  /// The hash with one contact moved.
  std::uint64_t hashAfter(int contact) const;

  const ScaledQpcc& problem() const { return *problem_; }
  auto columns() const { return table_.topLeftCorner(problem_->tableRows(), problem_->tableColumns()); }
  /// Columns of the unknowns, then of the constants: table rows x (unknowns + 1).
  auto map() const {
    return table_.block(0, problem_->size.contacts, problem_->tableRows(), problem_->size.unknowns + 1);
  }

  /// Rounding gathered by pivoting: the largest gap of an active contact at x = 0, by the original maps, relative to
  /// the terms it is summed from.
  double calcDrift() const;

  /// Pivots in an active set from scratch, whatever that takes.
  void rebuild(const std::vector<char>& active);
  void rebuild() { rebuild(active_); }

  /// Computes `map()` afresh from the original maps, without the lift, by iterative refinement. Where the active
  /// contacts depend on each other and leave no exact solution, returns false and `map` is of no use.
  bool refine(Eigen::Ref<MatX> map);

 private:
  void swapRowAndColumn(int row, int column);

  const DenseKernels* kernels_;
  const ScaledQpcc* problem_ = nullptr;
  MatX table_;
  VecX pivot_column_, pivot_row_, gap_;
  std::vector<char> active_, wanted_;
  std::vector<int> listed_;
  int active_count_ = 0;
  std::uint64_t hash_ = 0;
};

}  // namespace sinew
