#include "sinew/solver/contact_lcp.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

constexpr double kNegative = 1e-10;      // gaps and forces that must be pivoted
constexpr double kLeastExchange = 1e-6;  // motion of a row by its unknown, in scaled units

double calcRow(const ComplementarityTableau& tableau, int row, const Eigen::Ref<const VecX>& x) {
  const auto entries = tableau.map().row(row);
  return entries.head(x.size()).dot(x) + entries(x.size());
}

double pivotOf(const ComplementarityTableau& tableau, const HeldRow& pair) {
  return std::abs(tableau.map()(tableau.problem().size.contacts + pair.row, pair.unknown));
}

/// The unknown that moves the row most and is not taken.
HeldRow findBestPair(const ComplementarityTableau& tableau, const std::vector<HeldRow>& taken, int row) {
  HeldRow best{row, -1};
  double largest = kLeastExchange;
  for (int j = 0; j < tableau.problem().size.unknowns; ++j) {
    const auto takes = [j](const HeldRow& pair) { return pair.unknown == j; };
    if (std::any_of(taken.begin(), taken.end(), takes) || pivotOf(tableau, {row, j}) <= largest) continue;
    largest = pivotOf(tableau, {row, j});
    best.unknown = j;
  }
  return best;
}

}  // namespace

bool solveContactLcp(const Eigen::Ref<const VecX>& x, ComplementarityTableau& tableau) {
  const int n = tableau.problem().size.contacts;
  const int largest_first = 4 * n + 10;
  const int most = 50 * n + 200;
  for (int pivots = 0; pivots < most; ++pivots) {
    int entering = -1;
    double worst = -kNegative;
    for (int i = 0; i < n; ++i) {
      const double value = calcRow(tableau, i, x);
      if (!(value < worst)) continue;
      entering = i;
      worst = value;
      if (pivots >= largest_first) break;
    }
    if (entering < 0) return true;
    tableau.pivot(entering);
  }
  return false;
}

bool solveContactMcp(const std::vector<HeldRow>& held, Eigen::Ref<VecX> x, ComplementarityTableau& tableau) {
  const int nc = tableau.problem().size.contacts;
  std::size_t exchanged = 0;
  for (; exchanged < held.size(); ++exchanged) {
    const HeldRow& pair = held[exchanged];
    if (!(pivotOf(tableau, pair) > kLeastExchange)) break;
    tableau.exchange(pair.row, pair.unknown);
    x(pair.unknown) = tableau.problem().row_lower(nc + pair.row);
  }
  bool solved = exchanged == held.size() && solveContactLcp(x, tableau);
  while (exchanged-- > 0) {
    const HeldRow& pair = held[exchanged];
    const double effort = calcRow(tableau, nc + pair.row, x);
    tableau.exchange(pair.row, pair.unknown);
    x(pair.unknown) = effort;
  }
  return solved && x.allFinite();
}

void pairEqualities(ComplementarityTableau& tableau, std::vector<HeldRow>& held) {
  const ScaledQpcc& problem = tableau.problem();
  held.clear();
  for (int r = 0; r < problem.size.rows; ++r) {
    const int k = problem.size.contacts + r;
    if (problem.row_lower(k) != problem.row_upper(k)) continue;
    const HeldRow pair = findBestPair(tableau, held, r);
    if (pair.unknown < 0) continue;
    tableau.exchange(pair.row, pair.unknown);
    held.push_back(pair);
  }
  for (std::size_t k = held.size(); k-- > 0;) tableau.exchange(held[k].row, held[k].unknown);
}

}  // namespace sinew
