#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/dual_qp.h"
#include "sinew/solver/qpcc_relaxation.h"
#include "sinew/solver/search_budget.h"

namespace sinew {

/// What a tree search asks of the search around it.
class TreeGuide {
 public:
  virtual ~TreeGuide() = default;

  /// Objective of the best point known, in scaled units; infinite if none is.
  virtual double bestObjective() const = 0;

  /// Descends from the contacts of an actuation.
  virtual void descendFrom(const Eigen::Ref<const VecX>& x) = 0;

  /// Whether the contact is open in the best point known; false if none is.
  virtual bool isOpen(int contact) const = 0;

  /// Called once, when the first relaxation leaves something to search: descends from many other places.
  virtual void widen() = 0;

  /// Descends from somewhere else.
  virtual void restart() = 0;

  /// Whether the contact presses at an actuation.
  virtual bool presses(const Eigen::Ref<const VecX>& x, int contact) = 0;
};

/// Branch and bound on complementarity, depth first: of each node's relaxation the contact with the largest z_i g_i is
/// held open in one child and closed in the other. A child copies its parent's QP, adds one limit and goes on. Nothing
/// allocates after construction, which takes n_c + 1 QPs of the relaxation.
class QpccTree {
 public:
  enum class Outcome {
    kExhausted,   ///< nothing better than the best known point exists, up to the tolerance
    kInterrupted  ///< the budget ended, or something was numerically doubtful
  };

  explicit QpccTree(const QpccSizes& capacity);

  Outcome explore(const ScaledQpcc& problem, SearchBudget& budget, TreeGuide& guide);

 private:
  bool startRoot();
  bool explore(int depth);
  bool exploreChild(int depth, int contact, bool pressing);
  bool isDecided(int contact);
  int findBranch(const DualQp& node);
  double cutoff() const;

  const ScaledQpcc* problem_ = nullptr;
  SearchBudget* budget_ = nullptr;
  TreeGuide* guide_ = nullptr;
  QpccRelaxation relaxation_;
  std::vector<DualQp> nodes_;  ///< by depth
  std::vector<char> open_;     ///< contacts, then unknowns
  double slack_ = 0;           ///< of the relaxation's values as bounds
  bool doubtful_ = false;
};

}  // namespace sinew
