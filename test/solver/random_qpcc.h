#pragma once

#include <random>

#include "sinew/solver/qpcc_problem.h"

namespace sinew {

enum class QpccKind {
  kRandom,  ///< dense random compliance
  kBar,     ///< clamped slender bar, cables along it, obstacles beside it
  kLever    ///< the same with short cables and obstacles further out, on which the bar tilts: many local optima
};

const char* nameOf(QpccKind kind);

/// Rows are the actuators' displacements, 0 <= x (soft) the tensions; 3 effector rows. SI units. Feasible in general.
QpccProblem makeQpcc(QpccKind kind, int unknowns, int contacts, std::mt19937& random);

/// Contact `to` becomes a copy of `from`, `gap` further away.
void duplicateContact(int from, int to, double gap, QpccProblem& problem);

/// Contact `to` becomes the mean of two others, in its own place: a dependent row.
void averageContacts(int first, int second, int to, QpccProblem& problem);

/// Hard limits on x around `centre`, like rates: |x - centre| <= share of the soft range.
void limitRates(const VecX& centre, double share, QpccProblem& problem);

/// A row becomes an equality at the value it has at x = share of the soft range, without contacts.
void holdRow(int row, double share, QpccProblem& problem);

}  // namespace sinew
