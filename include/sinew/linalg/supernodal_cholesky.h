#pragma once

#include <cstdint>
#include <vector>

#include "sinew/common/worker_team.h"
#include "sinew/linalg/sparse_cholesky.h"
#include "sinew/linalg/supernodal_kernels.h"

namespace sinew {

/// Left-looking factorisation on dense panels of node blocks: every panel takes from the finished panels that reach
/// into its columns what is due, then its part of the matrix, and is factorised (Ng and Peyton's supernodal method).
/// All of that happens while it is in the cache. The numbers are all worked on by `SupernodalKernels`; here is which,
/// in what order.
///
/// Rows are condensed by halves: Y = L^-1 H^T, W = Y^T Y. A row's half solution is zero but along the paths of the
/// elimination tree from the panels that it touches up to the root, so rows are sorted by where they begin and the work
/// goes only where a group of them is not zero. The load is one row more.
///
/// Several threads take a share of the branches of the elimination tree each, then share the rows of the trunk.
class SupernodalCholesky : public SparseCholesky {
 public:
  /// `threads` count the caller's.
  SupernodalCholesky(const FactorPattern& pattern, int max_rows, int threads = 1,
                     InstructionSet set = chooseInstructionSet());

  int size() const override { return pattern_->size(); }
  bool factorise(const BlockMatrix& matrix) override;
  void condense(const BlockRows& H, const VecX& load, Eigen::Ref<MatX> compliance, Eigen::Ref<VecX> motion) override;
  void calcMotion(const VecX& force, VecX& x) override;

 private:
  using Panel = FactorPattern::Panel;
  using Groups = std::uint64_t;  // a bit for each group of rows

  /// What a thread works on, and what it alone writes. Its half solutions are those of its own branches; in the trunk
  /// they are what its branches add to them.
  struct Share {
    std::vector<int> panels;
    AlignedVector<double> half;  // a column per degree of freedom
    AlignedVector<double> gram;  // -Y^T Y of its columns
    AlignedVector<double> gathered;
    bool positive = true;
    double* column(int i, int stride) { return half.data() + static_cast<std::ptrdiff_t>(i) * stride; }
  };

  bool factorise(const std::vector<int>& panels, const BlockMatrix& matrix);
  void add(const BlockMatrix& matrix, const Panel& panel);
  void sortRows(const BlockRows& H);
  void findActive(const BlockRows& H);
  void clear(Share& share, const std::vector<int>& panels);
  void scatter(const BlockRows& H, const VecX& load, int owner);
  void substitute(Share& share, const std::vector<int>& panels, Groups groups);
  void multiply(Share& share, const std::vector<int>& panels);
  void joinTrunk(int member);
  void gather(Eigen::Ref<MatX> compliance, Eigen::Ref<VecX> motion);
  void substituteBackward(const std::vector<int>& panels, Share& share, double* x);
  int groupCount() const { return (rows_ + group_) / group_; }  // with the load's
  Groups groupOf(int place) const { return Groups{1} << static_cast<unsigned>(place / group_); }
  Groups groupsOf(int member) const;

  const FactorPattern* pattern_;
  const SupernodalKernels* kernels_;
  WorkerTeam team_;
  std::vector<Share> shares_;
  std::vector<int> trunk_;
  std::vector<std::vector<int>> trunk_shares_;  // for the product
  std::vector<int> owner_;                      // share by panel; the trunk is the caller's
  AlignedVector<double> values_;                // of the factor
  AlignedVector<double> inverse_diagonal_;

  int half_stride_;                          // places of the load and of the rows, padded to whole vectors
  int group_;                                // rows that share a bit
  int rows_ = 0;                             // of the last H
  AlignedVector<double> force_;              // by place
  std::vector<Groups> active_, was_active_;  // by panel
  std::vector<int> place_;                   // of each row in the half solutions; the load's is 0
  struct Key {
    int order, row;
  };
  std::vector<Key> keys_;
};

}  // namespace sinew
