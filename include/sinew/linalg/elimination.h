#pragma once

#include <vector>

#include "sinew/linalg/ordering.h"

namespace sinew {

/// An order of elimination and its cut into panels: consecutive blocks whose columns of the factor are stored, and
/// treated, as one dense panel.
struct Elimination {
  BlockOrder order;              ///< topological: what a subtree eliminates lies together
  std::vector<int> panel_start;  ///< into `order`, ascending; the number of blocks at the end
  double cost = 0;               ///< estimate, cycles of the longest way through all threads
};

/// Rough cycles of one core for a panel of `own` blocks of columns and `below` blocks of rows under its square: its own
/// factor, what it gives to its ancestors, and its part in the solve of some sixty right-hand sides.
double calcPanelCost(int own, int below);

/// Cuts an order into panels: columns of the factor with the same rows below become one supernode (George and Liu), a
/// supernode and its parent become one where the zeros that this stores cost less than the smaller blocks would, and
/// wide supernodes are cut again. Changes the order to one that is equivalent.
Elimination makeElimination(const BlockPattern& pattern, const BlockOrder& order, int threads = 1);
/// The cheapest of all orderings for so many threads; along the body unless another one is clearly cheaper.
Elimination makeElimination(const BlockPattern& pattern, int threads = 1);

}  // namespace sinew
