#pragma once

#include "sinew/body/fem_body.h"

namespace sinew {

/// Newton's iteration to static equilibrium under gravity and nodal forces `external` [N, free nodes]. Returns the
/// number of iterations, -1 when the imbalance does not fall to `tolerance` of the load.
inline int settle(FemBody& body, const VecX& external, double tolerance, int max_iterations = 60,
                  double max_node_step = 0.1) {
  const double load = (body.gravityForce() + external).norm();
  VecX motion(body.model().size());
  for (int k = 0; k < max_iterations; ++k) {
    body.linearise(StepRule());
    body.load() += external;
    if (body.load().norm() <= tolerance * load) return k;
    motion = body.load();
    if (!body.factorise()) {
      body.linearise(StepRule(), Tangent::kSemidefinite);
      if (!body.factorise()) return -1;
    }
    body.cholesky().solve(motion);
    body.advance(motion, max_node_step);
  }
  return -1;
}

}  // namespace sinew
