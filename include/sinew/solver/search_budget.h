#pragma once

#include <chrono>

#include "sinew/solver/dual_qp.h"

namespace sinew {

/// What a search may cost: counts, which make it repeatable, and a deadline.
struct QpccBudget {
  int max_pieces = 100000;
  int max_nodes = 100000;
  int restarts = 13;          ///< descents from elsewhere before branch and bound, the first of them from x = 0
  int elastic_restarts = 48;  ///< more of them while nothing is known that keeps the limits
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// What is left of a budget.
class SearchBudget : public QpInterruption {
 public:
  void start(const QpccBudget& budget);

  void countPiece() { ++pieces_; }
  void countNode() { ++nodes_; }
  int pieces() const { return pieces_; }
  int nodes() const { return nodes_; }

  bool piecesLeft() { return pieces_ < budget_.max_pieces && !due(); }
  bool nodesLeft() { return nodes_ < budget_.max_nodes && !due(); }

  /// Whether the deadline has passed.
  bool due() override;
  bool deadlinePassed() const { return deadline_passed_; }

 private:
  QpccBudget budget_;
  int pieces_ = 0, nodes_ = 0;
  bool deadline_passed_ = false;
};

}  // namespace sinew
