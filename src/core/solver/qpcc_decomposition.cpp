#include "sinew/solver/qpcc_decomposition.h"

#include <utility>

namespace sinew {

namespace {
constexpr int kMaxPlateau = 16;  // moves in a row without a gain
}

QpccDecomposition::QpccDecomposition(const QpccSizes& capacity) : current_(capacity), next_(capacity) {}

bool QpccDecomposition::solve(bool elastic, const ComplementarityTableau& tableau, PieceQp& piece, SearchBudget& budget,
                              PieceAnswer& answer) const {
  budget.countPiece();
  return piece.solve(tableau.map(), answer) || (elastic && piece.solveElastic(tableau.map(), answer));
}

void QpccDecomposition::record(bool first) {
  if (!visits_) return;
  const int descent = visits_->empty() ? 0 : visits_->back().descent + (first ? 1 : 0);
  visits_->push_back({descent, current_.merit.objective, current_.x});
}

bool QpccDecomposition::descend(bool elastic, ComplementarityTableau& tableau, PieceQp& piece, VisitedSets& visited,
                                SearchBudget& budget, QpccPoint& best) {
  best.answer.valid = false;
  if (!visited.insert(tableau.hash()) || !solve(elastic, tableau, piece, budget, current_)) return false;
  best.answer = current_;
  best.active = tableau.active();
  record(true);
  int plateau = 0;
  for (bool moved = true; moved;) {
    moved = false;
    for (std::size_t k = 0; k < current_.candidates.size() && !moved; ++k) {
      if (!budget.piecesLeft()) return true;
      const int contact = current_.candidates[k];
      if (!visited.insert(tableau.hashAfter(contact))) continue;
      tableau.pivot(contact);
      const bool worse = !solve(elastic, tableau, piece, budget, next_) || isBetter(current_.merit, next_.merit);
      const bool gain = !worse && isBetter(next_.merit, current_.merit);
      moved = gain || (!worse && ++plateau <= kMaxPlateau);
      if (!moved) tableau.pivot(contact);
      if (gain) plateau = 0;
    }
    if (!moved) break;
    std::swap(current_, next_);
    record(false);
    if (!isBetter(current_.merit, best.answer.merit)) continue;
    best.answer = current_;
    best.active = tableau.active();
  }
  return true;
}

}  // namespace sinew
