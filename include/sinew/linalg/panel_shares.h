#pragma once

#include <vector>

#include "sinew/linalg/factor_pattern.h"

namespace sinew {

/// The panels of a factor dealt to threads. Whole branches of the elimination tree go to one thread each: nothing in
/// them depends on any other branch. What they join into, the trunk, comes after all of them.
struct PanelShares {
  std::vector<std::vector<int>> branches;  ///< panels of each thread, ascending
  std::vector<int> trunk;                  ///< ascending; empty for one thread
  double cost = 0;                         ///< estimate, cycles of the longest way through all
};

PanelShares makePanelShares(const FactorPattern& pattern, int threads);

}  // namespace sinew
