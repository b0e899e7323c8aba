#pragma once

#include <cstdint>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/complementarity_tableau.h"
#include "sinew/solver/contact_lcp.h"
#include "sinew/solver/piece_qp.h"
#include "sinew/solver/qpcc_decomposition.h"
#include "sinew/solver/qpcc_problem.h"
#include "sinew/solver/qpcc_tree.h"
#include "sinew/solver/scaled_qpcc.h"
#include "sinew/solver/search_budget.h"
#include "sinew/solver/visited_sets.h"

namespace sinew {

/// Searches the global minimum of a QPCC while a budget lasts: descends from the guess and from x = 0, then by branch
/// and bound, which may prove the answer global, and from other actuations where the first bound does not yet do so.
/// There is always an answer: what the budget cuts short is the search for a better one. Descents start at the contacts
/// of an actuation, with equalities among the rows held. The starts continue a fixed random sequence, so that a run is
/// repeatable where counts bound the budget. Nothing allocates after construction.
class QpccSolver {
 public:
  explicit QpccSolver(const QpccSizes& capacity);

  /// Writes all of `solution`, returns its status. The sizes must be within the capacity; `guess` may be invalid.
  QpccStatus solve(const QpccProblem& problem, const QpccGuess& guess, const QpccBudget& budget,
                   QpccSolution& solution);

  /// Writes the points that each search from now on visits to `visits`, in SI units, which allocates; null ends that.
  void watch(std::vector<QpccVisit>* visits);

  /// Begins the random sequence anew.
  void forget() { random_ = 0; }

 private:
  class Guide;

  void search(const QpccGuess& guess, const QpccBudget& budget, QpccSolution& solution);
  void descendFrom(const Eigen::Ref<const VecX>& x);
  void descend();
  void keep(const QpccPoint& point);
  bool feasible() const { return best_.answer.valid && best_.answer.merit.feasible(); }
  bool withinReach(const PieceAnswer& answer) const;
  void startAtGuess(const QpccGuess& guess);
  void startAtRest();
  void widen();
  void restart();
  double drawUnit();
  bool exploreTree();

  double calcHandicap(const QpccGuess& guess) const;
  const QpccPoint& choose(const QpccGuess& guess, QpccSolution& solution) const;
  void conclude(const QpccProblem& problem, const QpccGuess& guess, QpccSolution& solution);
  void polish(const QpccPoint& point);
  void reportVisits();
  void report(const QpccProblem& problem, QpccSolution& solution) const;

  ScaledQpcc scaled_;
  ComplementarityTableau tableau_;
  PieceQp piece_;
  QpccDecomposition decomposition_;
  VisitedSets visited_;
  SearchBudget budget_;
  QpccTree tree_;
  QpccPoint found_, local_, reachable_, best_;
  PieceAnswer polished_;
  MatX map_;  ///< of the piece to report
  std::vector<HeldRow> held_;
  VecX start_, held_start_, guess_;
  VecX guess_row_, reach_;  ///< rows of the problem
  bool has_guess_ = false;
  std::vector<char> wanted_;
  std::vector<QpccVisit>* visits_ = nullptr;
  std::uint64_t random_ = 0;
  int restarts_ = 0, restarts_left_ = 0;
};

}  // namespace sinew
