#pragma once

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// min 1/2 x^T G x + g^T x  with  A x >= b  and  E x = f, by trying every active set of at most n limits: exponential,
/// and independent of any method that chooses among them. Finite limits in every direction, G semi-definite.
struct BruteForceQp {
  MatX G;
  VecX g;
  MatX A;
  VecX b;
  MatX E;
  VecX f;

  struct Answer {
    bool feasible = false;
    double objective = std::numeric_limits<double>::infinity();
    VecX x;
  };

  Answer solve() const {
    Answer best;
    std::vector<int> active;
    tryFrom(0, active, best);
    return best;
  }

 private:
  void tryFrom(int next, std::vector<int>& active, Answer& best) const {
    tryActive(active, best);
    if (static_cast<Eigen::Index>(active.size()) == g.size()) return;
    for (int i = next; i < A.rows(); ++i) {
      active.push_back(i);
      tryFrom(i + 1, active, best);
      active.pop_back();
    }
  }

  void tryActive(const std::vector<int>& active, Answer& best) const {
    const Eigen::Index n = g.size(), m = E.rows() + static_cast<Eigen::Index>(active.size());
    MatX N(m, n);
    VecX limits(m);
    N.topRows(E.rows()) = E;
    limits.head(E.rows()) = f;
    for (std::size_t k = 0; k < active.size(); ++k) {
      N.row(E.rows() + static_cast<Eigen::Index>(k)) = A.row(active[k]);
      limits[E.rows() + static_cast<Eigen::Index>(k)] = b[active[k]];
    }
    MatX kkt = MatX::Zero(n + m, n + m);
    kkt.topLeftCorner(n, n) = G;
    kkt.topRightCorner(n, m) = N.transpose();
    kkt.bottomLeftCorner(m, n) = N;
    VecX right(n + m);
    right.head(n) = -g;
    right.tail(m) = limits;
    const VecX x = kkt.completeOrthogonalDecomposition().solve(right).head(n);
    if (E.rows() > 0 && (E * x - f).cwiseAbs().maxCoeff() > kTolerance) return;
    if ((b - A * x).maxCoeff() > kTolerance) return;
    const double objective = 0.5 * x.dot(G * x) + g.dot(x);
    if (objective < best.objective) best = {true, objective, x};
  }

  static constexpr double kTolerance = 1e-9;
};

}  // namespace sinew
