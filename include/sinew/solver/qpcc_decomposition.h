#pragma once

#include <vector>

#include "sinew/solver/complementarity_tableau.h"
#include "sinew/solver/piece_qp.h"
#include "sinew/solver/search_budget.h"
#include "sinew/solver/visited_sets.h"

namespace sinew {

/// A point of a QPCC and the piece it lies in.
struct QpccPoint {
  explicit QpccPoint(const QpccSizes& capacity)
      : answer(capacity), active(static_cast<std::size_t>(capacity.contacts), 0) {}

  PieceAnswer answer;
  std::vector<char> active;
};

/// A point on the way of a search.
struct QpccVisit {
  int descent = 0;  ///< counts from 0
  double objective = 0;
  VecX x;
};

/// Descends from piece to piece (thesis 4.4): after each QP the contacts on their boundary whose dual says so change
/// sides, the largest dual first, as long as the answer gets no worse; no piece is entered twice, and few in a row
/// without a gain. Ends at a point no single change improves: a local optimum in general.
class QpccDecomposition {
 public:
  explicit QpccDecomposition(const QpccSizes& capacity);

  /// Starts at the piece of `tableau`, leaves it at some other one, and writes the best point. False if that piece is
  /// empty or was visited. With `elastic`, limits give way where they must.
  bool descend(bool elastic, ComplementarityTableau& tableau, PieceQp& piece, VisitedSets& visited,
               SearchBudget& budget, QpccPoint& best);

  /// Adds the points of descents to come to `visits`, in scaled units, which allocates; null ends that.
  void watch(std::vector<QpccVisit>* visits) { visits_ = visits; }

 private:
  void record(bool first);
  bool solve(bool elastic, const ComplementarityTableau& tableau, PieceQp& piece, SearchBudget& budget,
             PieceAnswer& answer) const;

  PieceAnswer current_, next_;
  std::vector<QpccVisit>* visits_ = nullptr;
};

}  // namespace sinew
