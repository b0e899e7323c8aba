#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/solver/complementarity_tableau.h"

namespace sinew {

/// A limited row held at a value, by the effort of an unknown.
struct HeldRow {
  int row = 0;
  int unknown = 0;
};

/// Moves the tableau to the active set of the contacts at given columns: 0 <= z, g >= 0, z^T g = 0. `x` gives each
/// unknown, or the row exchanged for it, in scaled units. The most negative entry is pivoted, and, should that go on
/// for long, the first negative one, which ends for a positive definite C_c (Murty 1974). False if it does not.
bool solveContactLcp(const Eigen::Ref<const VecX>& x, ComplementarityTableau& tableau);

/// The same with the `held` rows at their lower limit by whatever effort that takes (a mixed complementarity problem);
/// writes those efforts into x. False, with x and the tableau of no meaning but whole, if a row cannot be held by its
/// unknown, or as above.
bool solveContactMcp(const std::vector<HeldRow>& held, Eigen::Ref<VecX> x, ComplementarityTableau& tableau);

/// Pairs each equality among the limited rows with the unknown that moves it best. `held` must have the capacity.
void pairEqualities(ComplementarityTableau& tableau, std::vector<HeldRow>& held);

}  // namespace sinew
